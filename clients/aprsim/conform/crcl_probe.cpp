#include "clients/aprsim/conform/crcl_probe.hpp"

#include <thread>
#include <utility>

#include <fmt/format.h>

#include "crcl/command_codec.hpp"
#include "crcl/schema.hpp"
#include "crcl/status_codec.hpp"
#include "crcl/text.hpp"

namespace aprsim::client::conform {
namespace {

using std::chrono::steady_clock;

constexpr Milliseconds kConnect{5000}, kInit{35'000}, kClosing{2000}, kPollPeriod{20};

TcpSocket connected(const Target& target) {
  auto socket = TcpSocket::connect(target.host, target.port, steady_clock::now() + kConnect);
  if (!socket) throw GivenUp{socket.error()};
  return *std::move(socket);
}

}  // namespace

std::string in_words(const crcl::Status& status) {
  std::string text =
      fmt::format("{} of {}", name_of(status.command.state), status.command.command_id);
  const std::string description = status.command.description.value_or("");
  if (!description.empty()) text += ": " + crcl::shorten(description, 60);
  return text;
}

std::string command_document(std::string_view type, std::int64_t id, std::string_view elements) {
  return fmt::format(
      "<CRCLCommandInstance><CRCLCommand xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
      "xsi:type=\"{}\"><CommandID>{}</CommandID>{}</CRCLCommand></CRCLCommandInstance>",
      type, id, elements);
}

std::string get_status_document() { return command_document("GetStatusType", 1); }

CrclProbe::CrclProbe(const Target& target) : socket_(connected(target)) {}

std::int64_t CrclProbe::next_id() {
  static std::int64_t last = 70'000;
  return ++last;
}

void CrclProbe::send(std::string_view bytes) {
  const auto sent = socket_.send(bytes, steady_clock::now() + kAnswer);
  if (!sent) throw NotKept{sent.error().message};
}

std::int64_t CrclProbe::send(const crcl::CommandBody& body, std::int64_t id) {
  crcl::CommandInstance instance;
  instance.command.id = id;
  instance.command.body = body;
  send(crcl::encode_command(instance));
  return id;
}

SeenStatus CrclProbe::read(Milliseconds time) {
  const auto deadline = steady_clock::now() + time;
  while (true) {
    auto document = framer_.next();
    if (!document) throw NotKept{document.error().message()};
    if (*document) {
      auto status = crcl::decode_status(**document);
      if (!status) throw NotKept{"a status that cannot be read: " + status.error().message()};
      return {*std::move(*document), *std::move(status)};
    }
    const auto bytes = socket_.receive(deadline);
    if (!bytes && bytes.error().kind == FailureKind::kTimeout) {
      throw NotKept{fmt::format("no status within {} ms", time.count())};
    }
    if (!bytes) throw NotKept{bytes.error().message};
    framer_.append(*bytes);
  }
}

SeenStatus CrclProbe::poll(Milliseconds time) {
  send(get_status_document());
  return read(time);
}

template <typename Met>
SeenStatus CrclProbe::wait(Milliseconds time, const Met& met) {
  const auto deadline = steady_clock::now() + time;
  while (true) {
    SeenStatus seen = poll();
    if (met(seen.status.command)) return seen;
    if (steady_clock::now() > deadline) {
      throw NotKept{fmt::format("after {} ms {}", time.count(), in_words(seen.status))};
    }
    std::this_thread::sleep_for(kPollPeriod);
  }
}

SeenStatus CrclProbe::wait_over(std::int64_t id, Milliseconds time) {
  return wait(time, [id](const crcl::CommandStatus& command) {
    return command.command_id == id && (command.state == crcl::CommandState::kDone ||
                                        command.state == crcl::CommandState::kError);
  });
}

SeenStatus CrclProbe::wait_error(std::optional<std::int64_t> id, Milliseconds time) {
  return wait(time, [id](const crcl::CommandStatus& command) {
    return command.state == crcl::CommandState::kError ||
           (command.command_id == id && command.state == crcl::CommandState::kDone);
  });
}

SeenStatus CrclProbe::run(const crcl::CommandBody& body, Milliseconds time) {
  SeenStatus seen = wait_over(send(body), time);
  expect(seen.status.command.state == crcl::CommandState::kDone, in_words(seen.status));
  return seen;
}

// After one failure the timeout is shorter.
void CrclProbe::init() {
  static Milliseconds patience = kInit;
  try {
    run(crcl::InitCanon{}, patience);
  } catch (const NotKept&) {
    patience = kAnswer;
    throw;
  }
}

bool CrclProbe::silent(Milliseconds time) {
  const auto bytes = socket_.receive(steady_clock::now() + time);
  if (bytes) framer_.append(*bytes);
  if (!bytes && bytes.error().kind != FailureKind::kTimeout) throw NotKept{bytes.error().message};
  return !bytes;
}

bool CrclProbe::closed(Milliseconds time) {
  const auto deadline = steady_clock::now() + time;
  while (true) {
    const auto bytes = socket_.receive(deadline);
    if (!bytes) return bytes.error().kind == FailureKind::kConnection;
  }
}

void expect_state(const SeenStatus& seen, crcl::CommandState state) {
  expect(seen.status.command.state == state, in_words(seen.status));
}

Refusal refuse(const Target& target, const std::string& document, std::optional<std::int64_t> id) {
  Refusal refusal{CrclProbe(target), ""};
  refusal.other.init();
  CrclProbe probe(target);
  probe.send(document);
  // Other connections report it a little later.
  const SeenStatus seen = refusal.other.wait_error(id, CrclProbe::kAnswer);
  expect_state(seen, crcl::CommandState::kError);
  refusal.seen = in_words(seen.status);
  expect(!id || seen.status.command.command_id == *id || probe.closed(kClosing), refusal.seen);
  expect(!seen.status.command.description.value_or("").empty(), "an error without a description");
  if (const auto fault = crcl::schema_fault(seen.document)) throw NotKept{fault->message()};
  return refusal;
}

std::string refused(const Target& target, const std::string& document,
                    std::optional<std::int64_t> id) {
  Refusal refusal = refuse(target, document, id);
  refusal.other.init();
  return refusal.seen;
}

}  // namespace aprsim::client::conform
