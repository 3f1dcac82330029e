#include <cmath>
#include <fstream>
#include <iterator>
#include <ostream>

#include <fmt/format.h>

#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/crcl_session.hpp"
#include "crcl/decoder.hpp"
#include "crcl/program_loops.hpp"

namespace aprsim::client {
namespace {

Outcome<std::string> read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return failed(FailureKind::kUsage, "cannot read " + path);
  return std::string(std::istreambuf_iterator<char>(in), {});
}

std::string state_text(const crcl::Status& status) {
  std::string out{crcl::name_of(status.command.state)};
  if (status.command.description && !status.command.description->empty()) {
    out += ", " + *status.command.description;
  }
  if (status.pose) {
    const auto& point = status.pose->pose.point;
    out += fmt::format(", tool at {:.3f} {:.3f} {:.3f}", point.x, point.y, point.z);
  }
  return out;
}

/// Sends one document of a file as it stands there, and waits for what it leads to.
Outcome<crcl::Status> send_document(CrclSession& session, const std::string& document,
                                    const crcl::Command& command, double timeout_s) {
  if (const auto sent = session.send_raw(document); !sent) return tl::unexpected(sent.error());
  if (std::holds_alternative<crcl::GetStatus>(command.body)) return session.read_status();
  return session.wait_done(command.id, CrclSession::Seconds(timeout_s),
                           std::string(crcl::type_name(command.body)));
}

Outcome<void> check_timeout(double timeout_s) {
  if (std::isfinite(timeout_s) && timeout_s > 0) return {};
  return failed(FailureKind::kUsage, "--timeout must be above 0 s");
}

}  // namespace

Outcome<void> run_command(const CrclSendCommand& command, Console& console) {
  if (const auto ok = check_timeout(command.timeout_s); !ok) return ok;
  const auto text = read_file(command.file);
  if (!text) return tl::unexpected(text.error());
  auto session = CrclSession::connect(console.endpoints, command.robot);
  if (!session) return tl::unexpected(session.error());
  auto framer = crcl::Framer::for_commands();
  framer.append(*text);
  int count = 0;
  while (true) {
    auto document = framer.next();
    if (!document)
      return failed(FailureKind::kUsage, command.file + ": " + document.error().message());
    if (!*document) break;
    const auto instance = crcl::decode_command(**document);
    if (!instance)
      return failed(FailureKind::kUsage, command.file + ": " + instance.error().message());
    const auto status = send_document(*session, **document, instance->command, command.timeout_s);
    if (!status) return tl::unexpected(status.error());
    console.out << fmt::format("{} {}: {}\n", crcl::type_name(instance->command.body),
                               instance->command.id, state_text(*status));
    ++count;
  }
  if (count == 0)
    return failed(FailureKind::kUsage, command.file + " holds no CRCLCommandInstance");
  return {};
}

Outcome<void> run_command(const CrclRunCommand& command, Console& console) {
  if (const auto ok = check_timeout(command.timeout_s); !ok) return ok;
  const auto text = read_file(command.file);
  if (!text) return tl::unexpected(text.error());
  const auto program = crcl::decode_program(*text);
  if (!program) return failed(FailureKind::kUsage, command.file + ": " + program.error().message());
  const auto order = crcl::expand_loops(*program);
  if (!order) return failed(FailureKind::kUsage, command.file + ": " + order.error().message());
  auto session = CrclSession::connect(console.endpoints, command.robot);
  if (!session) return tl::unexpected(session.error());
  int index = 0;
  for (const std::size_t next : *order) {
    crcl::CommandInstance instance;
    instance.program_file = command.file;
    instance.program_index = index++;
    instance.program_length = static_cast<int>(order->size());
    instance.command = program->commands[next];
    console.out << fmt::format("{:>4}/{} {} ... ", index, order->size(),
                               crcl::type_name(instance.command.body));
    console.out.flush();
    const auto status = session->run(std::move(instance), CrclSession::Seconds(command.timeout_s));
    console.out << (status ? state_text(*status) : "failed") << '\n';
    if (!status) return tl::unexpected(status.error());
  }
  return {};
}

}  // namespace aprsim::client
