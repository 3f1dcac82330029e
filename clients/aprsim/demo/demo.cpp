#include <algorithm>
#include <ostream>
#include <set>

#include <fmt/format.h>

#include "clients/aprsim/commands.hpp"
#include "clients/aprsim/demo/belt.hpp"
#include "clients/aprsim/demo/pick_and_place.hpp"

namespace aprsim::client {
namespace {

// So many transfers are tried before a robot is said to reach none.
constexpr std::size_t kTries = 8;
// The robot that works at the belt when there is one.
constexpr const char* kBeltRobot = "motoman";

/// Tries transfers, best first, until one is done or fails for another reason than reach.
Outcome<void> transfer_one(DemoCell& cell, Arm& arm, const std::vector<Transfer>& transfers) {
  const auto none_left =
      failed(FailureKind::kCheck, arm.name() +
                                      " reaches no gear in a part tray with a free slot "
                                      "for it in a kit tray; 'aprsim reset' starts anew");
  std::set<std::string> out_of_reach;
  std::size_t tries = 0;
  for (const auto& transfer : transfers) {
    if (out_of_reach.contains(transfer.from.name()) || out_of_reach.contains(transfer.to.name())) {
      continue;
    }
    if (++tries > kTries) break;
    PickAndPlace task(cell, arm, transfer);
    auto done = task.run();
    if (done || task.out_of_reach().empty()) return done;
    out_of_reach.insert(task.out_of_reach());
    cell.out << arm.name() << ": " << task.out_of_reach() << " is out of reach\n";
  }
  return none_left;
}

/// One robot's pick and place. Whatever comes of it, the robot leaves the other's way.
Outcome<void> show_robot(DemoCell& cell, const Endpoints& endpoints,
                         const v1::RobotDescription& description, bool at_belt,
                         const std::string& preferred_tray) {
  auto arm = Arm::connect(endpoints, description);
  if (!arm) return tl::unexpected(arm.error());
  const auto view = cell.look();
  if (!view) return tl::unexpected(view.error());
  const auto done = transfer_one(cell, *arm, view->transfers(arm->p_WB(), at_belt, preferred_tray));
  if (!done && done.error().kind == FailureKind::kConnection) return done;
  if (!done) {
    if (auto cleared = arm->initialise(); !cleared) return done;
  }
  const auto home = arm->go_home();
  if (!done) return done;
  if (!home) return home;
  return arm->end();
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
    return failed(FailureKind::kCheck, "the cell is paused; 'aprsim resume' makes it go");
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
                  "the scene '" + description->scene() + "' has no robot to show anything with");
  }
  if (auto ok = check_robots(command.robots, *description); !ok) return ok;
  if (auto ok = check_health(connection); !ok) return ok;

  const bool all = command.robots.empty() && !command.belt;
  DemoCell cell{connection, *description, console.out};
  const auto show = [&](const v1::RobotDescription& robot, bool at_belt,
                        const std::string& tray) -> Outcome<void> {
    if (!all && std::ranges::find(command.robots, robot.name()) == command.robots.end()) return {};
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
  console.out << "demo: all done\n";
  return {};
}

}  // namespace aprsim::client
