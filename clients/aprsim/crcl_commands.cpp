#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <ostream>
#include <thread>

#include <fmt/format.h>

#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/crcl_session.hpp"
#include "crcl/command_codec.hpp"
#include "crcl/framer.hpp"
#include "crcl/program_loops.hpp"
#include "crcl/schema.hpp"

namespace aprsim::client {
namespace {

constexpr double kMaxRate = 1000;    // samples a second
constexpr double kJogTimeout = 120;  // [s]

Outcome<std::string> read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return failed(FailureKind::kUsage, "cannot read " + path);
  return std::string(std::istreambuf_iterator<char>(in), {});
}

/// How a command has ended.
std::string end_text(const crcl::Status& status) {
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

std::string joints_text(const crcl::Status& status) {
  std::string out;
  for (const crcl::JointStatus& joint : status.joints) {
    if (joint.position) out += fmt::format(" {:.3f}", *joint.position);
  }
  return out;
}

std::string gripper_text(const crcl::Status& status) {
  if (!status.gripper) return "";
  const auto* parallel = std::get_if<crcl::ParallelGripper>(&status.gripper->kind);
  return fmt::format("  gripper {}{}", parallel ? fmt::format("{:.1f}", parallel->separation) : "?",
                     status.gripper->holding.value_or(false) ? " holding" : "");
}

/// The whole status in one line.
std::string status_line(const crcl::Status& status) {
  const crcl::CommandStatus& command = status.command;
  std::string out = fmt::format("{} {} {}", command.command_id, command.name.value_or("-"),
                                crcl::name_of(command.state));
  if (command.program_index && command.program_length) {
    out += fmt::format(" [{}/{}]", *command.program_index, *command.program_length);
  }
  if (status.pose) {
    const crcl::Vector& p = status.pose->pose.point;
    out += fmt::format("  tool {:.3f} {:.3f} {:.3f}", p.x, p.y, p.z);
  }
  if (!status.joints.empty()) out += "  joints" + joints_text(status);
  out += gripper_text(status);
  if (command.description && !command.description->empty()) out += "  " + *command.description;
  return out;
}

/// The commands that move one joint or the tool by so much from where they are now.
Outcome<crcl::CommandBody> jog_from(const crcl::Status& now, const CrclJogCommand& command) {
  if (command.joint) {
    for (const crcl::JointStatus& joint : now.joints) {
      if (joint.joint != *command.joint || !joint.position) continue;
      crcl::ActuateJoint target{joint.joint, *joint.position + command.by, {}};
      target.details = crcl::JointSpeedAccel{command.speed, std::nullopt};
      return crcl::ActuateJoints{{target}, {}};
    }
    return failed(FailureKind::kUsage,
                  fmt::format("{} reports no joint {}; it has joints 1 to {}", command.robot,
                              *command.joint, now.joints.size()));
  }
  if (!now.pose) return failed(FailureKind::kRefused, command.robot + " reports no pose");
  crcl::MoveTo move{true, {now.pose->pose, std::nullopt}};
  double& axis = command.axis == 'x'   ? move.end.pose.point.x
                 : command.axis == 'y' ? move.end.pose.point.y
                                       : move.end.pose.point.z;
  axis += command.by;
  if (command.speed) {
    move.end.settings = crcl::PoseSettings{};
    move.end.settings->trans_speed = crcl::Rate{false, *command.speed};
  }
  return move;
}

/// How many documents of the text are valid; a failure names the first that is not.
Outcome<int> validate(const std::string& text) {
  constexpr std::size_t kLimit = crcl::kMaxProgramBytes;
  crcl::Framer framer(
      {{"CRCLCommandInstance", kLimit}, {"CRCLProgram", kLimit}, {"CRCLStatus", kLimit}});
  framer.append(text);
  int count = 0;
  while (true) {
    const auto document = framer.next();
    if (!document) return failed(FailureKind::kCheck, document.error().message());
    if (!*document) break;
    ++count;
    if (const auto fault = crcl::schema_fault(**document)) {
      return failed(FailureKind::kCheck, fmt::format("document {}: {}", count, fault->message()));
    }
  }
  if (framer.buffered() > 0 || count == 0) {
    return failed(FailureKind::kCheck,
                  fmt::format("document {} is no whole CRCLCommandInstance, CRCLProgram or "
                              "CRCLStatus",
                              count + 1));
  }
  return count;
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
                               instance->command.id, end_text(*status));
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
    console.out << (status ? end_text(*status) : "failed") << '\n';
    if (!status) return tl::unexpected(status.error());
  }
  return {};
}

Outcome<void> run_command(const CrclStatusCommand& command, Console& console) {
  if (!(command.rate_hz > 0 && command.rate_hz <= kMaxRate)) {
    return failed(FailureKind::kUsage,
                  fmt::format("--rate must be above 0 and at most {:g}", kMaxRate));
  }
  auto session = CrclSession::connect(console.endpoints, command.robot);
  if (!session) return tl::unexpected(session.error());
  const std::uint64_t count = command.watch ? command.count : 1;
  const auto period = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(1 / command.rate_hz));
  auto next = std::chrono::steady_clock::now();
  for (std::uint64_t shown = 0; count == 0 || shown < count; ++shown) {
    std::this_thread::sleep_until(next);
    next += period;
    const auto status = session->status();
    if (!status) return tl::unexpected(status.error());
    console.out << status_line(*status) << '\n';
    console.out.flush();
  }
  return {};
}

Outcome<void> run_command(const CrclJogCommand& command, Console& console) {
  auto session = CrclSession::connect(console.endpoints, command.robot);
  if (!session) return tl::unexpected(session.error());
  const CrclSession::Seconds timeout(kJogTimeout);
  if (command.init) {
    const auto ready = session->run(crcl::InitCanon{}, timeout);
    if (!ready) return tl::unexpected(ready.error());
  }
  const auto now = session->status();
  if (!now) return tl::unexpected(now.error());
  auto body = jog_from(*now, command);
  if (!body) return tl::unexpected(body.error());
  const auto done = session->run(std::move(*body), timeout);
  if (!done) return tl::unexpected(done.error());
  console.out << status_line(*done) << '\n';
  return {};
}

Outcome<void> run_command(const CrclValidateCommand& command, Console& console) {
  const auto text = read_file(command.file);
  if (!text) return tl::unexpected(text.error());
  const auto count = validate(*text);
  if (!count) return failed(count.error().kind, command.file + ": " + count.error().message);
  console.out << fmt::format("{}: {} valid document{}\n", command.file, *count,
                             *count == 1 ? "" : "s");
  return {};
}

}  // namespace aprsim::client
