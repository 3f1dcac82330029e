#include <algorithm>
#include <utility>

#include "protocols/crcl/command_lifecycle.hpp"

namespace aprsim::protocols {

void CommandLifecycle::refresh(const api::Snapshot& snapshot) {
  const api::RobotSnapshot& robot = snapshot.robots[static_cast<std::size_t>(robot_)];
  if (snapshot.epoch != epoch_) begin_epoch(snapshot);
  seen_ = std::max(seen_, snapshot.applied);
  if (!snapshot.world_fault.empty() && !error_) {
    latch_error("The simulation has stopped until the cell is reset: " + snapshot.world_fault);
  }
  const bool current = robot.action.ticket >= since_ && snapshot.applied >= since_;
  const bool failed = robot.action.state == api::ActionState::kError || robot.protective_stop;
  if (current && failed && !error_) latch_error(robot.action.description);
  if (progress_ == Progress::kWaiting) follow(snapshot);
}

// A robot of a cell that was reset has taken no command yet; that of a saved state has taken one
// that the world has applied before.
void CommandLifecycle::begin_epoch(const api::Snapshot& snapshot) {
  epoch_ = snapshot.epoch;
  since_ = 0;
  last_setting_ = 0;
  commander_.forget();
  services_.forget();
  program_.reset();
  error_.reset();
  const api::RobotSnapshot& robot = snapshot.robots[static_cast<std::size_t>(robot_)];
  const bool interrupted = std::exchange(progress_, Progress::kReady) == Progress::kWaiting;
  const api::Ticket ticket = robot.action.ticket;
  const bool before = ticket != 0 && (ticket <= seen_ || tickets_.find(ticket) != nullptr);
  if (before) {
    go_on(robot, interrupted);
  } else {
    begin_anew(interrupted);
  }
}

void CommandLifecycle::begin_anew(bool interrupted) {
  session_ = Session::kNever;
  latest_.description = "The cell was reset.";
  if (interrupted) latch_error("The cell was reset before " + *latest_.name + " ended.");
}

// The robot is in the session and at the command of the saved state.
void CommandLifecycle::go_on(const api::RobotSnapshot& robot, bool interrupted) {
  const bool failed = robot.action.state == api::ActionState::kError || robot.protective_stop;
  if (robot.initialized || failed) {
    session_ = Session::kOpen;
  } else {
    session_ = robot.action.kind == api::ActionKind::kEnd ? Session::kEnded : Session::kNever;
  }
  const TicketBook::Entry* command = tickets_.find(robot.action.ticket);
  if (command == nullptr) {
    latest_.description = "The cell went on from a saved state.";
    progress_ = Progress::kDone;
    if (interrupted) latch_error("A saved state was loaded before " + *latest_.name + " ended.");
    return;
  }
  latest_.name = command->name;
  latest_.command_id = command->command_id;
  latest_.description = "The cell went on from a saved state.";
  latest_.program_file.reset();
  latest_.program_index.reset();
  latest_.program_length.reset();
  progress_ = command->setting ? Progress::kDone : Progress::kWaiting;
  ticket_ = command->ticket;
  setting_ = command->setting;
}

void CommandLifecycle::follow(const api::Snapshot& snapshot) {
  const api::ActionStatus& action = snapshot.robots[static_cast<std::size_t>(robot_)].action;
  if (action.ticket < ticket_ && !(setting_ && snapshot.applied >= ticket_)) return;
  const bool arrived = action.ticket == ticket_ && action.state == api::ActionState::kDone;
  if (setting_ || arrived) {
    progress_ = Progress::kDone;
    if (!setting_ && !error_ && !action.description.empty()) add_description(action.description);
  } else if (action.ticket > ticket_ && !error_) {
    progress_ = Progress::kDone;
    if (action.ticket == last_setting_) return;  // our own, beside a program's command
    latch_error(*latest_.name + " was replaced by a command from another interface.");
  }
}

}  // namespace aprsim::protocols
