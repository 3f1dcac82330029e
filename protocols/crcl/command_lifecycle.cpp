#include "protocols/crcl/command_lifecycle.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include <spdlog/fmt/fmt.h>

#include "crcl/text.hpp"
#include "world/api/commands/concurrent_action.hpp"

namespace aprsim::crcl_server {
namespace {

// Commands that change only settings of this listener.
bool is_local(const crcl::CommandBody& body) {
  return crcl::holds_any_of<crcl::SetUnits, crcl::ConfigureJointReports,
                            crcl::ConfigureStatusReport, crcl::SetEndPoseTolerance,
                            crcl::SetIntermediatePoseTolerance, crcl::SetDefaultJointTolerances,
                            crcl::EnableSensor, crcl::DisableSensor>(body);
}

// Commands that begin, end or stop; they are admitted in every state.
bool is_always_admitted(const crcl::CommandBody& body) {
  return crcl::holds_any_of<crcl::InitCanon, crcl::EndCanon, crcl::StopMotion>(body);
}

// The Name of a command's status, as NIST's servers make it.
std::string reported_name(std::string_view type, const std::optional<std::string>& name) {
  constexpr std::size_t kMaxBytes = 120;
  if (!name || name->starts_with(type)) return std::string(type);
  std::string whole = std::string(type) + *name;
  if (whole.size() <= kMaxBytes) return whole;
  constexpr std::size_t kDots = 3;  // shorten() ends with them
  whole = crcl::shorten(whole, kMaxBytes);
  whole.resize(whole.size() - kDots);
  return whole;
}

// Whether a motion that the robot has accepted has ended in any way.
bool is_over(const Submission& motion, const api::RobotSnapshot& robot) {
  if (robot.action.ticket < motion.ticket) return false;
  const bool latest = robot.action.ticket == motion.ticket;
  return !robot.moving && !(latest && robot.action.state == api::ActionState::kWorking);
}

bool has_failed(const api::RobotSnapshot& robot) {
  return robot.action.state == api::ActionState::kError || robot.protective_stop;
}

}  // namespace

CommandLifecycle::CommandLifecycle(protocols::LimitedLog& log, const JointMap& joints, int robot,
                                   std::uint64_t epoch, protocols::RefusalSink* refusals)
    : log_(log), refusals_(refusals), joints_(joints), robot_(robot), epoch_(epoch) {
  latest_.command_id = -1;
}

void CommandLifecycle::begin(std::string_view type, const crcl::CommandInstance& instance) {
  latest_.name = reported_name(type, instance.command.name);
  latest_.command_id = instance.command.id;
  type_ = type;
  latest_.description.reset();
  latest_.program_file = instance.program_file;
  latest_.program_index = instance.program_index;
  latest_.program_length = instance.program_length;
  if (error_) latest_.description = "In error until InitCanon: " + *error_;
}

void CommandLifecycle::begin_refused(std::string_view type, const crcl::CommandInstance& instance) {
  refused_type_ = type;
  begin(refused_type_, instance);
}

bool CommandLifecycle::admits(const crcl::CommandBody& body) {
  if (is_always_admitted(body)) return true;
  if (!session_open_) {
    if (!error_) {
      latch_error(
          fmt::format("Not initialized when cmd={} received. Send InitCanon first.", type()));
    }
    return false;
  }
  return !error_ || is_local(body);
}

void CommandLifecycle::clear_error() {
  error_.reset();
  latest_.description.reset();
}

void CommandLifecycle::open_session(api::Ticket ticket) {
  session_open_ = true;
  initialized_at_ = ticket;
}

bool CommandLifecycle::submitted(const api::RobotAction& action, const Result<api::Ticket>& ticket,
                                 bool at_once) {
  if (!ticket) {
    latch_error(fmt::format("{} not accepted: {}", type(), ticket.error().message));
    return false;
  }
  // EndCanon is done at once, although the robot may still brake.
  const bool done_when_applied =
      at_once || api::is_setting(action) || std::holds_alternative<api::EndProgram>(action);
  submission_ = {*ticket, done_when_applied};
  progress_ = Progress::kWaiting;
  if (done_when_applied) last_setting_ = *ticket;
  history_.add(entry());
  if (api::leaves_motion(action)) return true;
  if (motion_) {
    const std::string ended =
        fmt::format("{} {} ended before its target.", motion_->type, motion_->command_id);
    log_.info(fmt::format("{} {}: {}", type(), latest_.command_id, ended));
    describe(ended);
    motion_.reset();
  }
  if (api::is_move(action)) motion_ = entry();
  return true;
}

void CommandLifecycle::done(std::optional<std::string> description) {
  progress_ = Progress::kDone;
  if (!error_) latest_.description = std::move(description);
}

void CommandLifecycle::append_note(const std::optional<std::string>& note) {
  if (!note) return;
  log_.warn(fmt::format("{} {}: {}", type(), latest_.command_id, *note));
  describe(*note);
}

// Appends to the description.
void CommandLifecycle::describe(const std::string& text) {
  if (error_ || text.empty()) return;
  latest_.description = latest_.description ? *latest_.description + "; " + text : text;
}

void CommandLifecycle::latch_error(std::string reason) {
  if (refusals_) {
    refusals_->refused(log_.name(), fmt::format("{}: {}", type_, reason));
  }
  latch(std::move(reason));
}

void CommandLifecycle::latch(std::string reason) {
  if (reason.empty()) reason = "The robot has given no reason.";
  log_.warn(fmt::format("{} {}: {}", type_, latest_.command_id, reason));
  error_ = reason;
  latest_.description = std::move(reason);
}

bool CommandLifecycle::observe(const api::Snapshot& snapshot) {
  const bool new_epoch = snapshot.epoch != epoch_;
  if (new_epoch) begin_epoch(snapshot);
  applied_ = std::max(applied_, snapshot.applied);
  if (!snapshot.world_fault.empty() && !error_) {
    latch("The simulation has stopped until the cell is reset: " + snapshot.world_fault);
  }
  // A snapshot from before InitCanon may still show the error that it clears.
  const api::RobotSnapshot& robot = robot_in(snapshot);
  const bool current =
      robot.action.ticket >= initialized_at_ && snapshot.applied >= initialized_at_;
  if (current && has_failed(robot) && !error_) {
    latch(joints_.explained(robot.action.description));
  }
  if (progress_ == Progress::kWaiting) update_progress(snapshot);
  if (motion_ && is_over(motion_->submission, robot)) motion_.reset();
  return new_epoch;
}

// After a reset the robot has executed no command. In a saved state it has executed one that the
// world has applied before.
void CommandLifecycle::begin_epoch(const api::Snapshot& snapshot) {
  epoch_ = snapshot.epoch;
  initialized_at_ = 0;
  last_setting_ = 0;
  motion_.reset();
  error_.reset();
  const api::RobotSnapshot& robot = robot_in(snapshot);
  const bool interrupted = std::exchange(progress_, Progress::kReady) == Progress::kWaiting;
  const api::Ticket ticket = robot.action.ticket;
  const bool before = ticket != 0 && (ticket <= applied_ || history_.find(ticket) != nullptr);
  if (before) {
    after_load(robot, interrupted);
  } else {
    after_reset(interrupted);
  }
}

void CommandLifecycle::after_reset(bool interrupted) {
  session_open_ = false;
  latest_.description = "The cell was reset.";
  if (interrupted) latch(fmt::format("The cell was reset before {} ended.", type()));
}

CommandHistory::Entry CommandLifecycle::entry() const {
  const std::string name = latest_.name.value_or("");
  return {submission_, latest_.command_id, type_, name == type_ ? "" : name};
}

// Session and command are those of the saved state.
void CommandLifecycle::after_load(const api::RobotSnapshot& robot, bool interrupted) {
  session_open_ = robot.initialized || has_failed(robot);
  latest_.description = "The cell went on from a saved state.";
  const CommandHistory::Entry* command = history_.find(robot.action.ticket);
  if (command == nullptr) {
    progress_ = Progress::kDone;
    if (interrupted) latch(fmt::format("A saved state was loaded before {} ended.", type()));
    return;
  }
  latest_.name = command->name.empty() ? std::string(command->type) : command->name;
  latest_.command_id = command->command_id;
  type_ = command->type;
  latest_.program_file.reset();
  latest_.program_index.reset();
  latest_.program_length.reset();
  submission_ = command->submission;
  progress_ = submission_.done_when_applied ? Progress::kDone : Progress::kWaiting;
}

CommandLifecycle::Outcome CommandLifecycle::outcome_of(const Submission& command,
                                                       const api::Snapshot& snapshot) const {
  const api::ActionStatus& action = robot_in(snapshot).action;
  if (command.done_when_applied) {
    const bool applied = snapshot.applied >= command.ticket || action.ticket >= command.ticket;
    return applied ? Outcome::kDone : Outcome::kPending;
  }
  if (action.ticket < command.ticket) return Outcome::kPending;
  if (action.ticket == command.ticket) {
    return action.state == api::ActionState::kDone ? Outcome::kDone : Outcome::kPending;
  }
  return action.ticket == last_setting_ ? Outcome::kBesideSetting : Outcome::kReplaced;
}

void CommandLifecycle::update_progress(const api::Snapshot& snapshot) {
  const Outcome outcome = outcome_of(submission_, snapshot);
  if (outcome == Outcome::kPending) return;
  if (outcome == Outcome::kDone) {
    progress_ = Progress::kDone;
    if (!submission_.done_when_applied)
      describe(joints_.explained(robot_in(snapshot).action.description));
    return;
  }
  if (error_) return;
  progress_ = Progress::kDone;
  if (outcome == Outcome::kReplaced) {
    latch(fmt::format("{} was replaced by a command from another interface.", type()));
  }
}

std::optional<Submission> CommandLifecycle::pending() const {
  if (progress_ != Progress::kWaiting) return std::nullopt;
  return submission_;
}

crcl::CommandState CommandLifecycle::state(bool program_runs) const {
  if (error_) return crcl::CommandState::kError;
  if (program_runs || progress_ == Progress::kWaiting) return crcl::CommandState::kWorking;
  return progress_ == Progress::kDone ? crcl::CommandState::kDone : crcl::CommandState::kReady;
}

crcl::CommandStatus CommandLifecycle::next_status(bool program_runs) {
  ++latest_.status_id;
  crcl::CommandStatus status = latest_;
  status.state = state(program_runs);
  return status;
}

}  // namespace aprsim::crcl_server
