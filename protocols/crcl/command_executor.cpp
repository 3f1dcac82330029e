#include "protocols/crcl/command_executor.hpp"

#include <algorithm>
#include <utility>
#include <variant>
#include <vector>

#include <spdlog/spdlog.h>

#include "crcl/command_codec.hpp"
#include "crcl/text.hpp"
#include "protocols/crcl/status_builder.hpp"
#include "protocols/ports/wire_faults.hpp"

namespace aprsim::crcl_server {
namespace {

constexpr std::size_t kMaxDescriptionBytes = 4096, kMaxMessageLog = 200;

// Bounds the commands of a program, so that one of settings alone blocks no client and no core: a
// burst, then a rate.
constexpr double kProgramBurst = 64, kProgramCommandsPerS = 1000;

// Commands that end an uploaded program: the robot cannot execute them beside another one.
bool ends_program(const crcl::CommandBody& body) {
  return crcl::holds_any_of<crcl::InitCanon, crcl::EndCanon, crcl::StopMotion, crcl::MoveTo,
                            crcl::MoveThroughTo, crcl::MoveScrew, crcl::ActuateJoints,
                            crcl::SetEndEffector, crcl::OpenToolChanger, crcl::CloseToolChanger,
                            crcl::Dwell, crcl::RunProgram>(body);
}

}  // namespace

// Executes one admitted command.
struct CommandExecutor::Visitor {
  CommandExecutor& robot;
  const Caller& caller;
  std::vector<api::Guard> guards;  // of the command, until an action carries them
  CommandLifecycle& lifecycle = robot.lifecycle_;
  ConnectionSettings& settings = *caller.settings;

  void operator()(const crcl::GetStatus&) const {}

  void operator()(const crcl::InitCanon&) {
    lifecycle.clear_error();
    const Result<api::Ticket> ticket = submit(api::InitRobot{});
    if (ticket) lifecycle.open_session(*ticket);
  }

  // Motion ends; the robot stays initialised, as by NIST's servers.
  void operator()(const crcl::EndCanon&) {
    if (!lifecycle.session_open()) return lifecycle.done();
    submit(api::EndProgram{});
  }

  // Outside a session nothing but a stream of motions moves the robot.
  void operator()(const crcl::StopMotion& stop) {
    if (!lifecycle.session_open() && !robot.follows_stream()) return lifecycle.done();
    submit(to_action(stop));
  }

  void operator()(const crcl::MoveTo& move) {
    Result<api::MoveTo> action = to_action(move, settings, robot.tolerances_);
    if (!action) return lifecycle.latch_error(action.error().message);
    const auto note = fit_pose(action->X_RT);
    if (!note) return lifecycle.latch_error(note.error().message);
    submit(*std::move(action));
    lifecycle.append_note(*note);
  }

  void operator()(const crcl::MoveThroughTo& move) {
    Result<api::MoveThroughTo> action = to_action(move, settings, robot.tolerances_);
    if (!action) return lifecycle.latch_error(action.error().message);
    std::optional<std::string> last_note;
    for (api::Waypoint& point : action->waypoints) {
      const auto note = fit_pose(point.X_RT);
      if (!note) return lifecycle.latch_error(note.error().message);
      if (*note) last_note = *note;
    }
    submit(*std::move(action));
    lifecycle.append_note(last_note);
  }

  void operator()(const crcl::MoveScrew& screw) {
    Result<api::MoveScrew> action = to_action(screw, settings);
    if (!action) return lifecycle.latch_error(action.error().message);
    std::optional<std::string> note;
    if (action->start) {
      const auto fitted = fit_pose(action->start->X_RT);
      if (!fitted) return lifecycle.latch_error(fitted.error().message);
      note = *fitted;
    }
    submit(*std::move(action));
    lifecycle.append_note(note);
  }

  void operator()(const crcl::ActuateJoints& command) {
    auto targets = to_targets(command, settings, robot.joints_, robot.tolerances_);
    if (!targets) return lifecycle.latch_error(targets.error().message);
    const auto note = fit(*targets, robot.joints_, robot.clamps_targets(), settings.joint_unit());
    if (!note) return lifecycle.latch_error(note.error().message);
    api::MoveJoints action = robot.joints_.to_move(*targets);
    // Joint numbers that the robot does not have are ignored.
    if (action.targets.empty() && !targets->empty()) return lifecycle.done();
    submit(std::move(action));
    lifecycle.append_note(*note);
  }

  void operator()(const crcl::OpenToolChanger&) { submit(api::SetToolChanger{.open = true}); }
  void operator()(const crcl::CloseToolChanger&) { submit(api::SetToolChanger{.open = false}); }
  void operator()(const crcl::SetEndEffector& set) { submit(to_action(set)); }

  void operator()(const crcl::Dwell& dwell) {
    const Result<api::Dwell> action = to_action(dwell);
    if (!action) return lifecycle.latch_error(action.error().message);
    submit(*action);
  }

  // Done at once: the robot applies it before any later command.
  void operator()(const crcl::SetRate& set) {
    const Result<api::SetMotionLimit> action = to_action(set.which, set.rate, settings);
    if (!action) return lifecycle.latch_error(action.error().message);
    if (submit(*action)) lifecycle.done();
  }

  void operator()(const crcl::Message& message) const {
    robot.log_.info(fmt::format("message from {}: {}", caller.peer,
                                protocols::log_text(message.text, kMaxMessageLog)));
    lifecycle.done(crcl::shorten(message.text, kMaxDescriptionBytes));
  }

  void operator()(const crcl::SetEndPoseTolerance& set) const {
    keep(robot.tolerances_.end, set.tolerance);
  }
  void operator()(const crcl::SetIntermediatePoseTolerance& set) const {
    keep(robot.tolerances_.intermediate, set.tolerance);
  }
  void operator()(const crcl::SetDefaultJointTolerances& set) const {
    if (const auto ok = check(set.tolerances); !ok) {
      return lifecycle.latch_error(ok.error().message);
    }
    robot.tolerances_.joints.clear();
    for (const crcl::JointTolerance& joint : set.tolerances) {
      if (joint.joint > joint_count()) continue;
      robot.tolerances_.joints.push_back(
          {joint.joint, robot.joints_.to_rad(joint.joint, joint.tolerance, settings.joint_unit())});
    }
    lifecycle.done();
  }

  void operator()(const crcl::SetUnits& set) const { configure(set); }
  void operator()(const crcl::ConfigureJointReports& command) const { configure(command); }
  void operator()(const crcl::ConfigureStatusReport& command) const { configure(command); }

  // Loads the program; execute() starts it.
  void operator()(const crcl::RunProgram& command) const {
    if (robot.in_program_) {
      return lifecycle.latch_error("RunProgram within a program is not supported.");
    }
    auto program = crcl::decode_program(command.text, robot.options_.max_program_bytes);
    if (!program && program.error().kind != crcl::ErrorKind::kBadValue) {
      return lifecycle.latch_error(
          "RunProgram runs a CRCLProgram document only; the text begins with \"" +
          crcl::shorten(crcl::trim(command.text), 40) + "\".");
    }
    if (!program) return lifecycle.latch_error("RunProgram: " + program.error().message());
    Result<ProgramRunner> runner =
        ProgramRunner::of_command(*std::move(program), lifecycle.command_id(), caller);
    if (!runner) return lifecycle.latch_error("RunProgram: " + runner.error().message);
    lifecycle.done();
    if (!runner->finished()) robot.program_ = *std::move(runner);
  }

  void operator()(const crcl::LoopBlockStart&) const { refuse_loop(); }
  void operator()(const crcl::LoopBlockEnd&) const { refuse_loop(); }

  // The commands that set or enable what RobotParameters keeps.
  template <typename Command>
  requires requires(RobotParameters& parameters, const Command& command,
                    ConnectionSettings& reports) {
    parameters.apply(command, reports);
  }
  void operator()(const Command& command) {
    const RobotParameters::Outcome action = robot.parameters_.apply(command, settings);
    if (!action) return lifecycle.latch_error(action.error().message);
    if (!*action) return lifecycle.done();
    submit(**action);
  }

 private:
  int joint_count() const { return robot.joints_.count(); }

  Result<std::optional<std::string>> fit_pose(Pose& X_RT) const {
    return fit(X_RT, robot.limits_, robot.clamps_targets(), settings.units().length);
  }

  // A setting carries no guards.
  Result<api::Ticket> submit(const api::RobotAction& action) {
    std::vector<api::Guard> carried;
    if (!api::is_setting(action)) carried = std::exchange(guards, {});
    Result<api::Ticket> ticket = robot.submitter_.submit(action, std::move(carried));
    const bool at_once =
        std::holds_alternative<api::SetGripper>(action) && !settings.waits_for_end_effector();
    lifecycle.submitted(action, ticket, at_once);
    return ticket;
  }

  void keep(std::optional<api::PoseTolerance>& kept, const crcl::PoseTolerance& tolerance) const {
    if (const auto ok = check(tolerance); !ok) return lifecycle.latch_error(ok.error().message);
    kept = in_si(tolerance, settings.units());
    lifecycle.done();
  }

  void refuse_loop() const {
    lifecycle.latch_error(
        fmt::format("{} is valid only within a program: send the whole CRCLProgram, or expand the "
                    "loop.",
                    lifecycle.type()));
  }

  template <typename Configuration>
  void configure(const Configuration& configuration) const {
    settings.apply(configuration);
    lifecycle.done();
  }
};

CommandExecutor::CommandExecutor(CommandExecutorOptions options, api::CommandSink& sink,
                                 const api::SnapshotSource& source)
    : options_(std::move(options)),
      source_(source),
      cell_(source.latest()->cell),
      joints_(description()),
      log_("crcl." + description().name),
      lifecycle_(log_, joints_, options_.robot, source.latest()->epoch, options_.refusals),
      submitter_(options_.robot, options_.endpoint, sink),
      parameters_(parameters_of(*cell_)),
      limits_(cartesian_limits(description(), options_.cartesian_min_R, options_.cartesian_max_R)),
      program_pace_(kProgramCommandsPerS, kProgramBurst) {}

void CommandExecutor::execute(const crcl::CommandInstance& instance, const Caller& caller) {
  observe(*source_.latest());
  ++commands_;
  if (ends_program(instance.command.body)) program_.reset();
  in_program_ = false;
  carry_out(instance, caller);
  if (!std::holds_alternative<crcl::RunProgram>(instance.command.body) || !program_) return;
  ProgramRunner loaded = *std::exchange(program_, std::nullopt);
  if (!lifecycle_.in_error()) start(std::move(loaded));
}

void CommandExecutor::execute(crcl::Program program, const Caller& caller) {
  observe(*source_.latest());
  ++commands_;
  program_.reset();
  const std::int64_t id = program.commands.empty() ? 0 : program.commands.front().id;
  Result<ProgramRunner> runner = ProgramRunner::of_document(std::move(program), caller);
  if (!runner) return refuse("CRCLProgram", id, runner.error().message);
  log_.info("program from " + caller.peer);
  start(*std::move(runner));
}

void CommandExecutor::refuse(std::string_view type, std::int64_t id, const std::string& reason) {
  observe(*source_.latest());
  ++commands_;
  keep_old_status();
  in_program_ = false;
  crcl::CommandInstance instance;
  instance.command.id = id;
  lifecycle_.begin_refused(type, instance);
  end_told_.reset();
  if (!lifecycle_.in_error()) lifecycle_.latch_error(reason);
}

void CommandExecutor::bad_document(const std::string& reason) {
  stop_robot();
  if (!lifecycle_.in_error()) lifecycle_.latch_error(reason);
}

void CommandExecutor::client_lost(const Caller& caller, const std::string& reason) {
  // Another client's loss must not stop the motion of this one.
  if (caller.peer != commander_) return;
  stop_robot();
  if (lifecycle_.in_error()) return;
  lifecycle_.fail("The connection of " + caller.peer + " was lost: " + reason);
}

bool CommandExecutor::follows_stream() const {
  const api::SnapshotPtr now = source_.latest();
  const auto index = static_cast<std::size_t>(options_.robot);
  return index < now->robots.size() && now->robots[index].motion.stream != 0;
}

void CommandExecutor::stop_robot() {
  observe(*source_.latest());
  program_.reset();
  if (lifecycle_.session_open()) {
    const auto stopped = submitter_.submit(api::StopMotion{api::StopKind::kFast});
    if (!stopped) spdlog::error("{}: cannot stop: {}", name(), stopped.error().message);
  }
}

void CommandExecutor::carry_out(const crcl::CommandInstance& instance, const Caller& caller) {
  const crcl::Command& command = instance.command;
  keep_old_status();
  lifecycle_.begin(crcl::type_name(command.body), instance);
  end_told_.reset();
  spdlog::debug("{}: {} {} from {}", name(), lifecycle_.type(), command.id, caller.peer);
  if (!lifecycle_.admits(command.body)) return;
  const crcl::Units units = caller.settings->units();  // a guard's, whatever the command sets
  auto guards = to_guards(command.guards, parameters_.sensors(), units);
  if (!guards) {
    if (!lifecycle_.in_error()) lifecycle_.latch_error(guards.error().message);
    return;
  }
  const bool required = std::ranges::any_of(*guards, &api::Guard::require_trigger);
  Visitor visitor{*this, caller, *std::move(guards)};
  std::visit(visitor, command.body);
  if (lifecycle_.pending()) commander_ = caller.peer;
  if (!visitor.guards.empty()) {
    // The command ended before a guard could be checked.
    if (required && !lifecycle_.in_error()) {
      lifecycle_.latch_error(
          fmt::format("{} ended without the required guard trigger.", lifecycle_.type()));
    }
  } else if (const auto pending = lifecycle_.pending(); pending && !command.guards.empty()) {
    guarded_ = to_guarded_command(pending->ticket, command.guards, parameters_.sensors(), units);
  }
}

PortFaults CommandExecutor::faults() const {
  const api::SnapshotPtr now = source_.latest();
  if (!now->faults) return {};
  using faults::Kind;
  return {.half_document = protocols::injected(*now, Kind::kCrclHalfDocument, options_.robot),
          .old_status = protocols::injected(*now, Kind::kCrclOldStatus, options_.robot),
          .late_status = protocols::injected_delay(*now, Kind::kCrclLateStatus, options_.robot),
          .slow = protocols::injected_delay(*now, Kind::kCrclSlow, options_.robot)};
}

void CommandExecutor::keep_old_status() {
  if (faults().old_status) {
    old_status_ = lifecycle_.next_status(program_runs());
  } else {
    old_status_.reset();
  }
}

void CommandExecutor::start(ProgramRunner program) {
  program_ = std::move(program);
  advance();
  if (program_ && wake_) wake_();
}

void CommandExecutor::advance() {
  const api::SnapshotPtr snapshot = source_.latest();
  observe(*snapshot);
  const auto now = options_.virtual_time ? protocols::RateLimit::Clock::time_point(snapshot->time)
                                         : protocols::RateLimit::Clock::now();
  while (program_ && step_done(*snapshot)) {
    if (program_->finished()) return program_.reset();
    if (!program_pace_.admit(now)) return;
    const crcl::CommandInstance instance = program_->next();
    if (std::holds_alternative<crcl::GetStatus>(instance.command.body)) continue;
    in_program_ = true;
    carry_out(instance, program_->caller());
    if (lifecycle_.in_error()) return program_.reset();
    program_->wait_for(lifecycle_.pending());
  }
}

void CommandExecutor::client_gone(const Caller& caller) {
  if (!options_.end_program_with_client || !program_ || program_->caller().peer != caller.peer) {
    return;
  }
  log_.info("the program of " + caller.peer + " ends with its client");
  program_.reset();
}

// Whether the program's next command may begin; ends a program that cannot continue.
bool CommandExecutor::step_done(const api::Snapshot& snapshot) {
  const std::optional<Submission> step = program_->pending();
  if (!step) return true;
  if (lifecycle_.in_error()) {
    program_.reset();
    return false;
  }
  switch (lifecycle_.outcome_of(*step, snapshot)) {
    case CommandLifecycle::Outcome::kPending:
      return false;
    case CommandLifecycle::Outcome::kDone:
      return true;
    case CommandLifecycle::Outcome::kBesideSetting:
      return !snapshot.robots[static_cast<std::size_t>(options_.robot)].moving;
    case CommandLifecycle::Outcome::kReplaced:
      break;
  }
  program_.reset();
  lifecycle_.latch_error("The program was interrupted by a command from another interface.");
  return false;
}

void CommandExecutor::observe(const api::Snapshot& snapshot) {
  if (!lifecycle_.observe(snapshot)) return;
  submitter_.forget();
  follow_scene(snapshot);
  parameters_.forget();
  program_.reset();
  program_pace_ = protocols::RateLimit(kProgramCommandsPerS, kProgramBurst);
}

void CommandExecutor::set_robot(int robot) {
  options_.robot = robot;
  lifecycle_.set_robot(robot);
  submitter_.set_robot(robot);
  const api::SnapshotPtr now = source_.latest();
  follow_scene(*now);
  observe(*now);
}

// A changed scene may move the robot, or change its joint conventions and tools.
void CommandExecutor::follow_scene(const api::Snapshot& snapshot) {
  const auto& now = snapshot.cell->scene_text;
  const auto before = cell_->scene_text;
  cell_ = snapshot.cell;
  if (now == before || (now && before && *now == *before)) return;
  joints_ = JointMap(description());
  limits_ = cartesian_limits(description(), options_.cartesian_min_R, options_.cartesian_max_R);
  parameters_ = parameters_of(*cell_);
}

RobotParameters CommandExecutor::parameters_of(const api::CellDescription& cell) const {
  return {description(), cell.tools, joints_, cell.light_curtain ? cell.light_curtain->beams : 0};
}

bool CommandExecutor::over() {
  if (program_) advance();
  observe(*source_.latest());
  return lifecycle_.state(program_runs()) != crcl::CommandState::kWorking;
}

bool CommandExecutor::first_to_tell_end(crcl::CommandState state) {
  const bool over = state == crcl::CommandState::kDone || state == crcl::CommandState::kError;
  if (!over || end_told_ == state) return false;
  end_told_ = state;
  return true;
}

crcl::Status CommandExecutor::status(const ConnectionSettings& settings) {
  if (program_) advance();
  const api::SnapshotPtr snapshot = source_.latest();
  observe(*snapshot);
  crcl::CommandStatus command = lifecycle_.next_status(program_runs());
  if (old_status_ && faults().old_status) {
    const std::int64_t status_id = command.status_id;
    command = *old_status_;
    command.status_id = status_id;
  }
  return build_status(std::move(command),
                      {.snapshot = *snapshot,
                       .robot = options_.robot,
                       .start_ms = options_.start_ms,
                       .submitter = submitter_,
                       .parameters = parameters_,
                       .joints = joints_,
                       .tolerances = tolerances_,
                       .limits = limits_,
                       .guarded = guarded_},
                      settings);
}

}  // namespace aprsim::crcl_server
