#include "protocols/web/topics/fault_log.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "protocols/net/limited_log.hpp"
#include "world/api/description/robot_identity.hpp"

namespace aprsim::web {
namespace {

constexpr std::size_t kMaxMessage = 300;

/// Replaces each number in the text by "#".
std::string without_numbers(const std::string& text) {
  std::string out;
  bool number = false;
  for (const char c : text) {
    const bool digit = c >= '0' && c <= '9';
    if (digit && !number) out += '#';
    if (!digit && !(number && c == '.')) out += c;
    number = digit || (number && c == '.');
  }
  return out;
}

std::string reason_of(api::DriveFault fault) {
  switch (fault) {
    case api::DriveFault::kNone:
      break;
    case api::DriveFault::kEmergencyStop:
      return "emergency stop";
    case api::DriveFault::kWatchdog:
      return "watchdog: no command in time";
    case api::DriveFault::kLightCurtain:
      return "stopped by the light curtain";
  }
  return "fault reset";
}

bool failed(const api::RobotSnapshot& robot) {
  return robot.action.state == api::ActionState::kError;
}

}  // namespace

void FaultLog::update(const api::SnapshotPtr& now, const std::string& problem,
                      std::chrono::system_clock::time_point wall, const Expected& expected) {
  if (now == before_ && problem == problem_) return;
  const api::SnapshotPtr before = std::exchange(before_, now);
  now_ = {now->epoch, std::chrono::duration<double>(now->time).count(), wall};
  detect_epoch(*before, *now);
  clear_gone(*before, *now);
  const int robots = static_cast<int>(std::min(before->robots.size(), now->robots.size()));
  for (int i = 0; i < robots; ++i) detect_robot(i, *before, *now, expected);
  detect_belt(*before, *now);
  detect_physics(*before, *now);
  detect_pace(*before, *now, problem);
}

void FaultLog::detect_epoch(const api::Snapshot& before, const api::Snapshot& now) {
  if (before.epoch == now.epoch) return;
  if (now.loaded_state) {
    add({FaultSeverity::kNote, "cell", "continued from the saved state '" + *now.loaded_state + "'",
         "load " + *now.loaded_state});
  } else {
    add({FaultSeverity::kNote, "cell", "reset"});
  }
}

/// A robot that has left the cell has no fault any more.
void FaultLog::clear_gone(const api::Snapshot& before, const api::Snapshot& now) {
  if (before.cell == now.cell || !before.cell || !now.cell) return;
  for (const api::RobotDescription& robot : before.cell->robots) {
    if (api::robot_named(*now.cell, robot.name)) continue;
    clear(robot.name, FaultSeverity::kStop);
    clear(robot.name, FaultSeverity::kError);
  }
}

void FaultLog::detect_robot(int index, const api::Snapshot& before, const api::Snapshot& now,
                            const Expected& expected) {
  const auto at = static_cast<std::size_t>(index);
  const api::RobotSnapshot& old = before.robots[at];
  const api::RobotSnapshot& robot = now.robots[at];
  const std::string& name = now.cell->robots[at].name;
  const std::string& why = robot.action.description;
  if (!robot.protective_stop) clear(name, FaultSeverity::kStop);
  if (!failed(robot)) clear(name, FaultSeverity::kError);
  const bool another = !failed(old) || old.action.ticket != robot.action.ticket ||
                       old.action.description != why || before.epoch != now.epoch;
  if (robot.protective_stop && (!old.protective_stop || before.epoch != now.epoch)) {
    add({.severity = FaultSeverity::kStop,
         .source = name,
         .message = why.empty() ? "protective stop" : why,
         .active = true});
  } else if (failed(robot) && another && !robot.protective_stop &&
             !(expected && expected(index, robot.action.ticket))) {
    clear(name, FaultSeverity::kError);  // a robot has one error at a time, the latest
    add({.severity = FaultSeverity::kError, .source = name, .message = why, .active = true});
  } else if (failed(old) && !failed(robot) && before.epoch == now.epoch &&
             !(expected && expected(index, old.action.ticket))) {
    add({FaultSeverity::kNote, name, "error cleared"});
  }
  const bool closed = robot.gripper.setting < 0.5;
  if (before.epoch == now.epoch && old.gripper.holding && !robot.gripper.holding && closed) {
    const auto body = static_cast<std::size_t>(old.gripper.held_body);
    const bool known = old.gripper.held_body >= 0 && body < before.cell->bodies.size();
    add({FaultSeverity::kError, name,
         fmt::format("lost {} from the closed gripper",
                     known ? before.cell->bodies[body].name : "an unknown part")});
  }
}

void FaultLog::detect_belt(const api::Snapshot& before, const api::Snapshot& now) {
  const api::DriveFault fault = now.conveyor.fault;
  if (fault == api::DriveFault::kNone) clear("belt", FaultSeverity::kStop);
  if (fault != before.conveyor.fault) {
    const bool stopped = fault != api::DriveFault::kNone;
    if (stopped) clear("belt", FaultSeverity::kStop);
    add({.severity = stopped ? FaultSeverity::kStop : FaultSeverity::kNote,
         .source = "belt",
         .message = reason_of(fault),
         .active = stopped});
  }
  if (!now.light_curtain.broken) {
    clear("cell", FaultSeverity::kWarning);
  } else if (!before.light_curtain.broken) {
    add({.severity = FaultSeverity::kWarning,
         .source = "cell",
         .message = "light curtain broken",
         .active = true});
  }
}

void FaultLog::detect_physics(const api::Snapshot& before, const api::Snapshot& now) {
  const std::uint64_t known = before.epoch == now.epoch ? before.physics_faults : 0;
  if (now.physics_faults > known) {
    add({.severity = FaultSeverity::kWarning,
         .source = "physics",
         .message =
             fmt::format("contact deeper than 0.5 mm ({:.2f} mm)", now.max_penetration_m * 1e3),
         .count = now.physics_faults - known});
  }
  if (now.world_fault.empty()) {
    clear("physics", FaultSeverity::kStop);
  } else if (now.world_fault != before.world_fault) {
    add({.severity = FaultSeverity::kStop,
         .source = "physics",
         .message = now.world_fault,
         .active = true});
  }
}

void FaultLog::detect_pace(const api::Snapshot& before, const api::Snapshot& now,
                           const std::string& problem) {
  if (now.missed_steps > before.missed_steps + kFewMissedSteps) {
    missed_steps_ += now.missed_steps - before.missed_steps;
    add({FaultSeverity::kNote, "cell",
         fmt::format("{} steps dropped in total: the machine is too slow", missed_steps_)});
  }
  // A fault of the world is in the list already.
  const std::string other = now.world_fault.empty() ? problem : "";
  if (other.empty()) {
    clear("simulation", FaultSeverity::kWarning);
  } else if (problem_.empty()) {
    add({.severity = FaultSeverity::kWarning,
         .source = "simulation",
         .message = other,
         .active = true});
  }
  problem_ = other;
}

void FaultLog::clear(const std::string& source, FaultSeverity severity) {
  for (Fault& fault : faults_) {
    if (!fault.active || fault.source != source || fault.severity != severity) continue;
    fault.active = false;
    ++revision_;
  }
}

void FaultLog::add(Seen seen) {
  ++revision_;
  std::string message = protocols::log_text(seen.message, kMaxMessage);
  std::string cause = fmt::format("{} {} {}", static_cast<int>(seen.severity), seen.source,
                                  seen.cause.empty() ? without_numbers(message) : seen.cause);
  auto known = std::find(causes_.begin(), causes_.end(), cause);
  if (known == causes_.end()) {
    if (faults_.size() >= kMaxFaults) make_room();
    faults_.push_back({.id = ++last_id_,
                       .severity = seen.severity,
                       .source = std::move(seen.source),
                       .first = now_});
    known = causes_.insert(causes_.end(), std::move(cause));
  }
  Fault& fault = faults_[static_cast<std::size_t>(known - causes_.begin())];
  fault.message = std::move(message);
  fault.count += seen.count;
  fault.last = now_;
  fault.active = seen.active;
}

void FaultLog::make_room() {
  const auto rank = [](const Fault& f) { return std::tuple(f.active, f.severity, f.last.wall); };
  const auto least =
      std::min_element(faults_.begin(), faults_.end(),
                       [&](const Fault& a, const Fault& b) { return rank(a) < rank(b); });
  causes_.erase(causes_.begin() + (least - faults_.begin()));
  faults_.erase(least);
  ++discarded_;
}

}  // namespace aprsim::web
