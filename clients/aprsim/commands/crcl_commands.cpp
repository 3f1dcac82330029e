#include "clients/aprsim/commands/crcl_commands.hpp"

#include <algorithm>
#include <chrono>
#include <ostream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/commands/crcl_file_commands.hpp"
#include "clients/aprsim/commands/live_view.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/text/crcl_text.hpp"
#include "clients/wires/crcl_session.hpp"

namespace aprsim::client {
namespace {

constexpr CrclSession::Seconds kShortTimeout{15};  // for commands without motion, and stops

/// Commands that move one joint or the tool relative to the present position.
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

/// Sends InitCanon if requested, then the jog.
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

/// Runs one short command.
Outcome<void> run_one(const std::string& robot, crcl::CommandBody body, Console& console,
                      const std::string& before = "") {
  auto session = CrclSession::connect(console.endpoints, robot, interruption::requested);
  if (!session) return tl::unexpected(session.error());
  const auto done = session->run(std::move(body), kShortTimeout);
  if (!done) return tl::unexpected(done.error());
  show_status(robot, *done, console, before);
  return {};
}

void add_crcl_status(CLI::App& crcl, CommandLine& line) {
  auto [status, command] = add_command<CrclStatusCommand>(crcl, line, "status",
                                                          "Show the status of a robot in one line");
  add_robot(*status, command->robot);
  auto* watch = status->add_flag("--watch", command->watch, "Repeat until interrupted");
  constexpr double kMaxRate = 1000;
  status->add_option("--rate", command->rate_hz, "Samples per second (default 10)")
      ->type_name("HZ")
      ->check(above_zero(kMaxRate))
      ->needs(watch);
  status->add_option("--count", command->count, "Exit after N samples")
      ->type_name("N")
      ->needs(watch);
  offer_json(*status, line);
}

void add_crcl_actions(CLI::App& crcl, CommandLine& line) {
  auto [init, init_command] = add_command<CrclInitCommand>(
      crcl, line, "init",
      "Send InitCanon: clear errors and make the robot ready; it does not move");
  add_robot(*init, init_command->robot);
  offer_json(*init, line);

  auto [stop, stop_command] = add_command<CrclStopCommand>(crcl, line, "stop", "Stop all robots");
  stop->add_option("--robot", stop_command->robots, "Stop only this robot; repeatable")
      ->type_name("ROBOT")
      ->check(not_empty())
      ->allow_extra_args(false);
  choose(stop->add_option_function<std::string>(
             "--condition",
             [c = stop_command](const std::string& word) {
               c->condition = word == "fast"        ? crcl::StopCondition::kFast
                              : word == "immediate" ? crcl::StopCondition::kImmediate
                                                    : crcl::StopCondition::kNormal;
             },
             "Stop condition: normal keeps the drives on (default), fast switches them off after a "
             "second, "
             "immediate at once"),
         {"normal", "fast", "immediate"});
  offer_json(*stop, line);

  auto [gripper, gripper_command] =
      add_command<CrclGripperCommand>(crcl, line, "gripper", "Open or close a robot's gripper");
  gripper
      ->add_option_function<std::string>(
          "SETTING",
          [c = gripper_command](const std::string& text) {
            const auto setting = text == "open"    ? std::optional(1.0)
                                 : text == "close" ? std::optional(0.0)
                                                   : number_of(text);
            if (!setting || *setting < 0 || *setting > 1) {
              throw CLI::ValidationError(
                  "SETTING", "'" + text + "' is not open, close, or a number from 0 to 1");
            }
            c->setting = *setting;
          },
          "open, close, or a number from 0 (closed) to 1 (open)")
      ->type_name("open|close")
      ->required();
  add_robot(*gripper, gripper_command->robot);
  offer_json(*gripper, line);
}

void add_crcl_jog(CLI::App& crcl, CommandLine& line) {
  auto [jog, command] = add_command<CrclJogCommand>(
      crcl, line, "jog", "Move one joint (degrees), or the tool straight along an axis (mm)");
  add_robot(*jog, command->robot);
  auto* joint =
      jog->add_option("--joint", command->joint, "Number of the joint, from 1")->type_name("N");
  auto* axis = jog->add_option("--axis", command->axis, "Axis of the robot's frame");
  choose(axis, {"x", "y", "z"});
  axis->excludes(joint);
  // A forgotten option must not move the arm.
  jog->callback([&line, joint, axis, c = command] {
    if (joint->empty() && axis->empty()) throw CLI::RequiredError("--joint or --axis");
    line.command = *c;
  });
  jog->add_option("--by", command->by, "Distance from the current position [degrees or mm]")
      ->type_name("DEGREES|MM")
      ->check(finite())
      ->required();
  jog->add_option("--speed", command->speed, "Speed [degrees or mm per second]")
      ->type_name("SPEED")
      ->check(above_zero());
  jog->add_flag("--init", command->init, "Send InitCanon first");
  add_timeout(*jog, command->timeout_s, "Stop the robot after this time (default 120)");
  offer_json(*jog, line);
}

}  // namespace

Outcome<void> run_command(const CrclStatusCommand& command, Console& console) {
  auto session = CrclSession::connect(console.endpoints, command.robot, interruption::requested);
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
      view.show(console.escaped(status_line(*status, console.screen.out) + "\n"));
      console.out.flush();
    } else {
      show_status(command.robot, *status, console);
    }
    if (!console.out.good()) break;  // which the program reports
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
  // An unreachable robot does not prevent the others from being stopped.
  Outcome<void> all =
      robots.empty() ? failed(FailureKind::kUsage, "the cell has no robot") : Outcome<void>();
  for (const auto& robot : robots) {
    const auto done = run_one(robot, crcl::StopMotion{command.condition}, console, robot + ": ");
    if (!done && all) all = done;
  }
  return all;
}

Outcome<void> run_command(const CrclJogCommand& command, Console& console) {
  const interruption::Hold hold;
  auto session = CrclSession::connect(console.endpoints, command.robot, interruption::requested);
  if (!session) return tl::unexpected(session.error());
  const auto done = jog(*session, command);
  if (done) {
    show_status(command.robot, *done, console);
    return {};
  }
  // A jog that timed out or was interrupted is stopped.
  if (done.error().kind == FailureKind::kTimeout && !interruption::happened()) {
    const auto stopped = session->stop();
    return failed(
        FailureKind::kTimeout,
        done.error().message + (stopped ? "; it has been stopped"
                                        : "; it MAY STILL MOVE: " + stopped.error().message));
  }
  return tl::unexpected(session->stopped_after(done.error()));
}

void add_crcl(CLI::App& app, CommandLine& line) {
  CLI::App* crcl = app.add_subcommand("crcl", "Command and query robots over CRCL");
  crcl->require_subcommand(1);
  add_crcl_status(*crcl, line);
  add_crcl_actions(*crcl, line);
  add_crcl_jog(*crcl, line);
  add_crcl_files(*crcl, line);
}

}  // namespace aprsim::client
