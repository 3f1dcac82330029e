// Bytes of one CRCL connection through framing, codec and a robot's command executor.
// First byte: how the bytes are split into packets and what the robot makes of its commands.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include <spdlog/spdlog.h>

#include "crcl/command_codec.hpp"
#include "crcl/framer.hpp"
#include "crcl/schema.hpp"
#include "crcl/status_codec.hpp"
#include "protocols/crcl/command_executor.hpp"
#include "tests/support/fake_cell.hpp"

namespace {

using namespace aprsim;

constexpr std::size_t kCommandBytes = 8192, kProgramBytes = 32'768;

void demand(bool truth) {
  if (!truth) std::abort();
}

/// One robot, one connection, and a robot that completes or fails its commands.
class Connection {
 public:
  explicit Connection(unsigned mood) : mood_(mood), executor_(options(), world_, world_) {}

  void take(std::string_view bytes) {
    framer_.append(bytes);
    while (!broken_) {
      const auto document = framer_.next();
      if (!document) return end(document.error());
      if (!*document) return;
      demand((*document)->size() <= (framer_.last_root() == 0 ? kCommandBytes : kProgramBytes));
      handle(**document);
      live();
      answer();
    }
  }

 private:
  static crcl_server::CommandExecutorOptions options() {
    crcl_server::CommandExecutorOptions out;
    out.max_program_bytes = kProgramBytes;
    return out;
  }

  void end(const crcl::Error& error) {
    demand(!error.message().empty());
    executor_.bad_document(error.message());
    broken_ = true;
    answer();
  }

  void handle(const std::string& document) {
    static_cast<void>(crcl::schema_fault(document));
    if (framer_.last_root() != 0) {
      auto program = crcl::decode_program(document, kProgramBytes);
      if (!program) return refuse(program.error());
      return executor_.execute(std::move(*program), caller_);
    }
    const auto instance = crcl::decode_command(document, kCommandBytes);
    if (!instance) return refuse(instance.error());
    // Every decoded command can be encoded again.
    const auto again = crcl::decode_command(crcl::encode_command(*instance), 16 * kCommandBytes);
    demand(again && *again == *instance);
    if (std::holds_alternative<crcl::GetStatus>(instance->command.body)) return;
    executor_.execute(*instance, caller_);
  }

  void refuse(const crcl::Error& error) {
    if (error.kind != crcl::ErrorKind::kBadValue) return end(error);
    executor_.refuse(error.command_type, error.command_id.value_or(0), error.message());
  }

  /// The robot gets on with its latest command.
  void live() {
    const auto count = world_.commands().size();
    if (count == seen_) return;
    seen_ = count;
    const unsigned turn = mood_ + static_cast<unsigned>(count);
    const auto state = turn % 7 == 0   ? api::ActionState::kError
                       : turn % 3 == 0 ? api::ActionState::kWorking
                                       : api::ActionState::kDone;
    world_.report(0, count, state, state == api::ActionState::kError ? "no" : "");
    if (executor_.runs_program()) executor_.advance();
  }

  void answer() {
    const crcl::Status status = executor_.status(*caller_.settings);
    const std::string document = crcl::encode_status(status);
    demand(!crcl::schema_fault(document));
    demand(crcl::decode_status(document).has_value());
    demand(status.command.status_id > last_status_);
    last_status_ = status.command.status_id;
    const bool error = status.command.state == crcl::CommandState::kError;
    demand(!error || !status.command.description.value_or("").empty());
  }

  unsigned mood_;
  test::FakeCell world_;
  crcl_server::CommandExecutor executor_;
  crcl_server::Caller caller_{
      std::make_shared<crcl_server::ConnectionSettings>(crcl::Units{}, true), "fuzz"};
  crcl::Framer framer_ = crcl::Framer::for_commands(kCommandBytes, kProgramBytes);
  std::size_t seen_ = 0;
  std::int64_t last_status_ = 0;
  bool broken_ = false;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  spdlog::set_level(spdlog::level::off);
  const unsigned mood = data[0];
  const std::string_view stream(reinterpret_cast<const char*>(data) + 1, size - 1);
  Connection connection(mood % 16);
  const std::size_t packet = 1 + (mood / 16) * 97;
  for (std::size_t at = 0; at < stream.size(); at += packet) {
    connection.take(stream.substr(at, packet));
  }
  return 0;
}
