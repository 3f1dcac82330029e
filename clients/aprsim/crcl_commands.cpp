#include <algorithm>
#include <chrono>
#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/crcl_session.hpp"
#include "clients/aprsim/crcl_text.hpp"
#include "clients/aprsim/interruption.hpp"
#include "clients/aprsim/live_view.hpp"

namespace aprsim::client {
namespace {

constexpr CrclSession::Seconds kShortTimeout{15};  // for what moves no arm, or stops it

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

/// InitCanon if asked for, then the jog from where the robot is.
Outcome<crcl::Status> jog(CrclSession& session, const CrclJogCommand& command) {
  if (command.init) {
    auto ready = session.run(crcl::InitCanon{}, kShortTimeout);
    if (!ready) return ready;
  }
  const auto now = session.status();
  if (!now) return now;
  auto body = jog_from(*now, command);
  if (!body) return tl::unexpected(body.error());
  return session.run(std::move(*body), CrclSession::Seconds(command.timeout_s));
}

void show_status(const std::string& robot, const crcl::Status& status, Console& console,
                 const std::string& before = "") {
  console.show(before + status_line(status, console.screen.out) + "\n", status_json(robot, status));
}

/// One command that is soon done.
Outcome<void> run_one(const std::string& robot, crcl::CommandBody body, Console& console,
                      const std::string& before = "") {
  auto session = CrclSession::connect(console.endpoints, robot);
  if (!session) return tl::unexpected(session.error());
  const auto done = session->run(std::move(body), kShortTimeout);
  if (!done) return tl::unexpected(done.error());
  show_status(robot, *done, console, before);
  return {};
}

}  // namespace

Outcome<void> run_command(const CrclStatusCommand& command, Console& console) {
  auto session = CrclSession::connect(console.endpoints, command.robot);
  if (!session) return tl::unexpected(session.error());
  const std::uint64_t count = command.watch ? command.count : 1;
  const bool in_place = command.watch && console.screen.live && !console.json;
  LiveView view(console.out);
  const auto period = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(1 / command.rate_hz));
  auto next = std::chrono::steady_clock::now();
  for (std::uint64_t shown = 0; count == 0 || shown < count; ++shown) {
    interruption::sleep_until(next);
    next += period;
    const auto status = session->status();
    if (!status) return tl::unexpected(status.error());
    if (in_place) {
      view.show(status_line(*status, console.screen.out) + "\n");
      console.out.flush();
    } else {
      show_status(command.robot, *status, console);
    }
    if (!console.out.good()) return failed(FailureKind::kCheck, "cannot write the output");
  }
  return {};
}

Outcome<void> run_command(const CrclInitCommand& command, Console& console) {
  return run_one(command.robot, crcl::InitCanon{}, console);
}

Outcome<void> run_command(const CrclGripperCommand& command, Console& console) {
  return run_one(command.robot, crcl::SetEndEffector{command.setting}, console);
}

Outcome<void> run_command(const CrclStopCommand& command, Console& console) {
  std::vector<std::string> robots = command.robots;
  if (robots.empty()) {
    for (const auto& [name, port] : console.endpoints.crcl) robots.push_back(name);
  }
  // One that cannot be reached keeps no other from being stopped.
  Outcome<void> all =
      robots.empty() ? failed(FailureKind::kUsage, "there is no robot to stop") : Outcome<void>();
  for (const auto& robot : robots) {
    const auto done = run_one(robot, crcl::StopMotion{command.condition}, console, robot + ": ");
    if (!done && all) all = done;
  }
  return all;
}

Outcome<void> run_command(const CrclJogCommand& command, Console& console) {
  const interruption::Hold hold;
  auto session = CrclSession::connect(console.endpoints, command.robot);
  if (!session) return tl::unexpected(session.error());
  const auto done = jog(*session, command);
  if (done) {
    show_status(command.robot, *done, console);
    return {};
  }
  // A jog that nobody waits for any more goes no further.
  if (done.error().kind == FailureKind::kTimeout && !interruption::happened()) {
    const auto stopped = session->stop();
    return failed(
        FailureKind::kTimeout,
        done.error().message + (stopped ? "; it has been stopped"
                                        : "; it MAY STILL MOVE: " + stopped.error().message));
  }
  return tl::unexpected(session->stopped_after(done.error()));
}

}  // namespace aprsim::client
