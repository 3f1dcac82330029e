#include "clients/aprsim/commands/demo_commands.hpp"

#include <algorithm>
#include <chrono>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/console.hpp"
#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/commands/option_parsing.hpp"
#include "clients/aprsim/demo/belt.hpp"
#include "clients/aprsim/demo/pick_and_place.hpp"
#include "clients/aprsim/demo/reach.hpp"

namespace aprsim::client {
namespace {

constexpr auto kSettleTimeout = std::chrono::seconds(8);
// The robot that works at the belt when there is one.
constexpr const char* kBeltRobot = "motoman";

Failure none_left(const std::string& robot, const std::vector<Transfer>& transfers,
                  const CellView& view) {
  std::string why;
  if (!transfers.empty()) {
    why = fmt::format(
        "{} reaches no gear that is left in a part tray and fits a free slot of a "
        "kit tray ({} such transfers are beyond its reach)",
        robot, transfers.size());
  } else if (view.has_gear_in_part_tray()) {
    why = robot + ": no kit tray has a free slot for a gear that is left in the part trays";
  } else {
    why = robot + ": no gear is left in the part trays";
  }
  return {FailureKind::kCheck, why + "; 'aprsim reset' restarts the cell"};
}

/// Tries transfers, best first, until one is done or fails for another reason than reach.
Outcome<void> transfer_one(DemoCell& cell, Arm& arm, const CellView& view,
                           const std::vector<Transfer>& transfers) {
  Reach reach(arm.p_WB());
  for (const auto& transfer : transfers) {
    if (reach.excludes(transfer.from) || reach.excludes(transfer.to)) continue;
    PickAndPlace task(cell, arm, transfer);
    auto done = task.run();
    if (done || !task.refusal()) return done;
    reach.exclude(*task.refusal());
    const std::string place = task.refusal()->place.name();
    cell.report(arm.name(), "out_of_reach", place + " is out of reach", {{"place", place}});
  }
  return tl::unexpected(none_left(arm.name(), transfers, view));
}

/// ", holding PART" for a robot that holds a part; else empty.
std::string held_text(DemoCell& cell, const std::string& robot) {
  const auto snapshot = cell.connection.snapshot();
  if (!snapshot) return "";
  const auto found = std::ranges::find(snapshot->robots(), robot, &v1::RobotState::name);
  if (found == snapshot->robots().end() || !found->gripper().holding()) return "";
  return fmt::format(", holding {}; 'aprsim reset' puts it back", found->gripper().held_body());
}

/// The cell once everything is at rest, or on timeout. After a reset or a stop of the belt, parts
/// settle for some simulated milliseconds, and only parts at rest can be picked.
Outcome<CellView> view_at_rest(DemoCell& cell) {
  const auto rests = [](const v1::Snapshot& snapshot) {
    return std::ranges::all_of(snapshot.bodies(), [](const v1::BodyState& body) {
      return body.resting() || body.has_lost_step();
    });
  };
  if (const auto looked = cell.wait_until(rests, kSettleTimeout); !looked) {
    return tl::unexpected(looked.error());
  }
  return cell.view();
}

/// Picks and places with one robot. Afterwards the robot moves out of the way of the others;
/// after an interruption it stops at once.
Outcome<void> show_robot(DemoCell& cell, const Endpoints& endpoints,
                         const v1::RobotDescription& description, bool at_belt,
                         const std::string& preferred_tray) {
  auto arm = Arm::connect(endpoints, description);
  if (!arm) return tl::unexpected(arm.error());
  const auto work = [&]() -> Outcome<void> {
    const auto view = view_at_rest(cell);
    if (!view) return tl::unexpected(view.error());
    const auto done =
        transfer_one(cell, *arm, *view, view->transfers(arm->p_WB(), at_belt, preferred_tray));
    if (interruption::requested()) return done;
    if (!done && done.error().kind == FailureKind::kConnection) return done;
    if (!done) {
      if (auto cleared = arm->initialise(); !cleared) return done;
    }
    const auto home = arm->go_home();
    if (!done) return done;
    if (!home) return home;
    return arm->end();
  };
  const auto done = work();
  if (!interruption::happened()) return done;
  Failure failure =
      arm->stopped_after(done ? Failure{FailureKind::kInterrupted, "interrupted"} : done.error());
  failure.message += held_text(cell, description.name());
  return tl::unexpected(failure);
}

Outcome<void> check_robots(const std::vector<std::string>& wanted,
                           const v1::CellDescription& cell) {
  for (const auto& name : wanted) {
    if (std::ranges::find(cell.robots(), name, &v1::RobotDescription::name) ==
        cell.robots().end()) {
      return failed(FailureKind::kUsage,
                    fmt::format("the scene '{}' has no robot '{}'", cell.scene(), name));
    }
  }
  return {};
}

Outcome<void> check_health(CellConnection& connection) {
  const auto snapshot = connection.snapshot();
  if (!snapshot) return tl::unexpected(snapshot.error());
  if (!snapshot->world_fault().empty()) {
    return failed(FailureKind::kCheck, "the simulation has stopped: " + snapshot->world_fault());
  }
  if (snapshot->paused()) {
    return failed(FailureKind::kCheck, "the cell is paused; 'aprsim resume' continues it");
  }
  return {};
}

}  // namespace

Outcome<void> run_command(const DemoCommand& command, Console& console) {
  CellConnection connection(console.endpoints);
  const auto description = connection.cell();
  if (!description) return tl::unexpected(description.error());
  if (description->robots().empty()) {
    return failed(FailureKind::kCheck,
                  "the scene '" + description->scene() + "' has no robot for the demo");
  }
  if (auto ok = check_robots(command.robots, *description); !ok) return ok;
  if (auto ok = check_health(connection); !ok) return ok;

  const bool all = command.robots.empty() && !command.belt;
  const interruption::Hold hold;
  DemoCell cell{connection, *description, console};
  const auto show = [&](const v1::RobotDescription& robot, bool at_belt,
                        const std::string& tray) -> Outcome<void> {
    if (!all && std::ranges::find(command.robots, robot.name()) == command.robots.end()) return {};
    if (interruption::requested()) return failed(FailureKind::kInterrupted, "interrupted");
    return show_robot(cell, console.endpoints, robot, at_belt, tray);
  };
  const auto at_belt = [&](const v1::RobotDescription& robot) {
    return description->has_conveyor() && robot.name() == kBeltRobot;
  };
  for (const auto& robot : description->robots()) {
    if (at_belt(robot)) continue;
    if (auto done = show(robot, false, ""); !done) return done;
  }
  std::string tray;
  if (all || command.belt) {
    auto brought = bring_tray(cell, console.endpoints, kBeltRobot);
    if (!brought) return tl::unexpected(brought.error());
    tray = *brought;
  }
  for (const auto& robot : description->robots()) {
    if (!at_belt(robot)) continue;
    if (auto done = show(robot, true, tray); !done) return done;
  }
  cell.report("demo", "done", "all done", {});
  return {};
}

void add_demo(CLI::App& app, CommandLine& line) {
  auto [demo, command] = add_command<DemoCommand>(
      app, line, "demo",
      "Pick and place with the robots and run the belt, over CRCL, Modbus and vision");
  demo->add_option("--robot", command->robots, "Run only this robot; repeatable")
      ->type_name("ROBOT")
      ->check(not_empty())
      ->allow_extra_args(false);
  demo->add_flag("--belt", command->belt, "Run only the belt, and the robots named with --robot");
  offer_json(*demo, line, "Print one JSON object for each action");
}

}  // namespace aprsim::client
