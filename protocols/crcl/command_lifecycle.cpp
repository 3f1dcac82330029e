#include "protocols/crcl/command_lifecycle.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>
#include <variant>

#include <spdlog/spdlog.h>

#include "crcl/text.hpp"
#include "protocols/crcl/si_conversion.hpp"

namespace aprsim::protocols {
namespace {

constexpr std::size_t kMaxDescriptionBytes = 4096;

template <typename T, typename... Ts>
constexpr bool is_one_of = (std::is_same_v<T, Ts> || ...);

// Commands that change only what this listener keeps.
bool is_local(const crcl::CommandBody& body) {
  return std::visit(
      []<typename T>(const T&) {
        return is_one_of<T, crcl::SetUnits, crcl::ConfigureJointReports,
                         crcl::ConfigureStatusReport, crcl::SetEndPoseTolerance,
                         crcl::SetIntermediatePoseTolerance, crcl::SetDefaultJointTolerances,
                         crcl::EnableSensor, crcl::DisableSensor>;
      },
      body);
}

// Commands that end an uploaded program: those that the robot cannot do beside another one.
bool replaces(const crcl::CommandBody& body) {
  return std::visit(
      []<typename T>(const T&) {
        return is_one_of<T, crcl::InitCanon, crcl::EndCanon, crcl::StopMotion, crcl::MoveTo,
                         crcl::MoveThroughTo, crcl::MoveScrew, crcl::ActuateJoints,
                         crcl::SetEndEffector, crcl::OpenToolChanger, crcl::CloseToolChanger,
                         crcl::Dwell, crcl::RunProgram>;
      },
      body);
}

// Commands that begin, end or stop, which no state forbids.
bool is_always_admitted(const crcl::CommandBody& body) {
  return std::holds_alternative<crcl::InitCanon>(body) ||
         std::holds_alternative<crcl::EndCanon>(body) ||
         std::holds_alternative<crcl::StopMotion>(body);
}

}  // namespace

// Carries out one admitted command.
struct CommandLifecycle::Executor {
  CommandLifecycle& link;
  const std::shared_ptr<ConnectionSettings>& caller;
  const std::string& peer;
  ConnectionSettings& settings = *caller;

  void operator()(const crcl::InitCanon&) const {
    link.error_.reset();
    link.latest_.description.reset();
    const Result<api::Ticket> ticket = link.commander_.submit(api::InitRobot{});
    if (ticket) {
      link.session_ = Session::kOpen;
      link.since_ = *ticket;
    }
    link.wait_for(ticket, false);
  }

  void operator()(const crcl::EndCanon&) const {
    if (link.session_ != Session::kOpen) return link.done();
    link.session_ = Session::kEnded;
    link.wait_for(link.commander_.submit(api::EndRobot{}), true);
  }

  void operator()(const crcl::GetStatus&) const {}

  // Outside a session nothing of ours moves, and a robot may refuse commands then.
  void operator()(const crcl::StopMotion& stop) const {
    if (link.session_ != Session::kOpen) return link.done();
    link.wait_for(link.commander_.submit(to_action(stop)), false);
  }

  void operator()(const crcl::MoveTo& move) const {
    Result<api::MoveTo> action = to_action(move, settings, link.tolerances_.end);
    if (!action) return link.latch_error(action.error().message);
    const auto note = fit_pose(action->X_RT);
    if (!note) return link.latch_error(note.error().message);
    submit(action);
    link.append_note(*note);
  }
  void operator()(const crcl::MoveThroughTo& move) const {
    Result<api::MoveThroughTo> action =
        to_action(move, settings, link.tolerances_.intermediate, link.tolerances_.end);
    if (!action) return link.latch_error(action.error().message);
    std::optional<std::string> notes;
    for (api::Waypoint& point : action->waypoints) {
      const auto note = fit_pose(point.X_RT);
      if (!note) return link.latch_error(note.error().message);
      if (*note) notes = *note;
    }
    submit(action);
    link.append_note(notes);
  }
  void operator()(const crcl::MoveScrew& screw) const {
    Result<api::MoveScrew> action = to_action(screw, settings);
    if (!action) return link.latch_error(action.error().message);
    std::optional<std::string> note;
    if (action->start) {
      const auto fitted = fit_pose(action->start->X_RT);
      if (!fitted) return link.latch_error(fitted.error().message);
      note = *fitted;
    }
    submit(action);
    link.append_note(note);
  }
  void operator()(const crcl::OpenToolChanger&) const {
    submit(Result<api::SetToolChanger>({.open = true}));
  }
  void operator()(const crcl::CloseToolChanger&) const {
    submit(Result<api::SetToolChanger>({.open = false}));
  }

  void operator()(const crcl::ActuateJoints& command) const {
    Result<api::MoveJoints> action = command_to_joints(command);
    if (!action) return link.latch_error(action.error().message);
    const auto note =
        fit(*action, link.description(), link.options_.clamp_targets, settings.joint_unit());
    if (!note) return link.latch_error(note.error().message);
    submit(action);
    link.append_note(*note);
  }
  void operator()(const crcl::SetEndEffector& set) const {
    link.wait_for(link.commander_.submit(to_action(set)), false);
  }
  void operator()(const crcl::Dwell& dwell) const { submit(to_action(dwell)); }

  void operator()(const crcl::SetRate& set) const {
    const Result<api::SetMotionLimit> action = to_action(set.which, set.rate, settings);
    if (!action) return link.latch_error(action.error().message);
    link.done_with(link.commander_.submit(*action));
  }

  void operator()(const crcl::Message& message) const {
    spdlog::info("{}: message from {}: {}", link.name_, peer, message.text);
    link.done(crcl::shorten(message.text, kMaxDescriptionBytes));
  }

  void operator()(const crcl::SetEndPoseTolerance& set) const {
    if (const auto ok = check(set.tolerance); !ok) return link.latch_error(ok.error().message);
    link.tolerances_.end = in_si(set.tolerance, settings.units());
    link.done();
  }
  void operator()(const crcl::SetIntermediatePoseTolerance& set) const {
    if (const auto ok = check(set.tolerance); !ok) return link.latch_error(ok.error().message);
    link.tolerances_.intermediate = in_si(set.tolerance, settings.units());
    link.done();
  }
  void operator()(const crcl::SetDefaultJointTolerances& set) const {
    if (const auto ok = check(set.tolerances, joint_count()); !ok) {
      return link.latch_error(ok.error().message);
    }
    link.tolerances_.joints.clear();
    for (const crcl::JointTolerance& joint : set.tolerances) {
      link.tolerances_.joints.push_back(
          {joint.joint, crcl::to_si(joint.tolerance, settings.joint_unit())});
    }
    link.done();
  }

  void operator()(const crcl::SetUnits& set) const { configure(set); }
  void operator()(const crcl::ConfigureJointReports& command) const { configure(command); }
  void operator()(const crcl::ConfigureStatusReport& command) const { configure(command); }

  void operator()(const crcl::RunProgram& command) const { link.run_text(command, caller, peer); }
  void operator()(const crcl::LoopBlockStart&) const { loop_alone(); }
  void operator()(const crcl::LoopBlockEnd&) const { loop_alone(); }

  template <typename Service>
  requires requires(RobotParameters& services, const Service& command, ConnectionSettings& report) {
    services.take(command, report);
  }
  void operator()(const Service& command) const {
    const RobotParameters::Outcome action = link.services_.take(command, settings);
    if (!action) return link.latch_error(action.error().message);
    if (!*action) return link.done();
    link.wait_for(link.commander_.submit(**action), true);
  }

 private:
  Result<api::MoveJoints> command_to_joints(const crcl::ActuateJoints& command) const {
    return to_action(command, settings, joint_count(), link.tolerances_.joints);
  }

  int joint_count() const { return static_cast<int>(link.description().joints.size()); }

  Result<std::optional<std::string>> fit_pose(Pose& X_RT) const {
    return fit(X_RT, link.limits_, link.options_.clamp_targets, settings.units().length);
  }

  void loop_alone() const {
    link.latch_error(
        *link.latest_.name +
        " stands only within a program: send the whole CRCLProgram, or expand the loop.");
  }

  template <typename Action>
  void submit(const Result<Action>& action) const {
    if (!action) return link.latch_error(action.error().message);
    link.wait_for(link.commander_.submit(*action), false);
  }

  template <typename Configuration>
  void configure(const Configuration& configuration) const {
    settings.apply(configuration);
    link.done();
  }
};

CommandLifecycle::CommandLifecycle(CommandLifecycleOptions options, api::CommandSink& sink,
                                   const api::SnapshotSource& source)
    : options_(std::move(options)),
      robot_(options_.robot),
      source_(source),
      commander_(robot_, options_.endpoint, sink),
      cell_(source.latest()->cell),
      services_(description(), cell_->light_curtain ? cell_->light_curtain->beams : 0),
      limits_(cartesian_limits(description(), options_.cartesian_min_R, options_.cartesian_max_R)) {
  name_ = "crcl." + description().name;
  epoch_ = source_.latest()->epoch;
  latest_.command_id = -1;
}

void CommandLifecycle::execute(const crcl::CommandInstance& instance,
                               const std::shared_ptr<ConnectionSettings>& settings,
                               const std::string& peer) {
  refresh(*source_.latest());
  if (replaces(instance.command.body)) program_.reset();
  in_program_ = false;
  carry_out(instance, settings, peer);
}

void CommandLifecycle::carry_out(const crcl::CommandInstance& instance,
                                 const std::shared_ptr<ConnectionSettings>& settings,
                                 const std::string& peer) {
  const crcl::Command& command = instance.command;
  begin(std::string(crcl::type_name(command.body)), instance);
  spdlog::debug("{}: {} {} from {}", name_, *latest_.name, command.id, peer);
  if (!admits(command.body)) return;
  const crcl::Units units = settings->units();
  auto guards = GuardBook::to_world(command.guards, services_.sensors(), units);
  if (!guards) {
    if (!error_) latch_error(guards.error().message);
    return;
  }
  const bool required = std::any_of(guards->begin(), guards->end(),
                                    [](const api::Guard& guard) { return guard.require_trigger; });
  commander_.guard_next(std::move(*guards));
  std::visit(Executor{*this, settings, peer}, command.body);
  if (commander_.drop_guards()) {
    // The command is over before anything could be looked at.
    if (required && !error_)
      latch_error(*latest_.name + " ended without the required guard trigger.");
  } else if (progress_ == Progress::kWaiting) {
    guards_.remember(ticket_, command.guards, services_.sensors(), units);
  }
}

void CommandLifecycle::refuse(const std::string& type, std::int64_t id, const std::string& reason) {
  refresh(*source_.latest());
  in_program_ = false;
  crcl::CommandInstance instance;
  instance.command.id = id;
  begin(type, instance);
  if (!error_) latch_error(reason);
}

void CommandLifecycle::bad_document(const std::string& reason) {
  refresh(*source_.latest());
  program_.reset();
  if (session_ == Session::kOpen) {
    const auto stopped = commander_.submit(api::StopMotion{api::StopKind::kFast});
    if (!stopped) spdlog::error("{}: cannot stop: {}", name_, stopped.error().message);
  }
  if (!error_) latch_error(reason);
}

void CommandLifecycle::begin(const std::string& type, const crcl::CommandInstance& instance) {
  latest_.name = type;
  latest_.command_id = instance.command.id;
  latest_.description.reset();
  latest_.program_file = instance.program_file;
  latest_.program_index = instance.program_index;
  latest_.program_length = instance.program_length;
  if (error_) latest_.description = "In error until InitCanon: " + *error_;
}

bool CommandLifecycle::admits(const crcl::CommandBody& body) {
  if (is_always_admitted(body)) return true;
  const bool harmless = is_local(body) || std::holds_alternative<crcl::Message>(body);
  const bool in_session = session_ == Session::kOpen || (session_ == Session::kEnded && harmless);
  if (!in_session) {
    if (!error_) {
      latch_error("Not initialized when cmd=" + *latest_.name + " received. Send InitCanon first.");
    }
    return false;
  }
  return !error_ || is_local(body);
}

void CommandLifecycle::done(std::optional<std::string> description) {
  progress_ = Progress::kDone;
  if (!error_) latest_.description = std::move(description);
}

void CommandLifecycle::append_note(const std::optional<std::string>& note) {
  if (!note) return;
  spdlog::warn("{}: {} {}: {}", name_, *latest_.name, latest_.command_id, *note);
  if (!error_) latest_.description = *note;
}

bool CommandLifecycle::taken(const Result<api::Ticket>& ticket, bool setting) {
  if (!ticket) {
    latch_error(*latest_.name + " not taken: " + ticket.error().message);
    return false;
  }
  tickets_.note({*ticket, latest_.command_id, *latest_.name, setting});
  if (setting) last_setting_ = *ticket;
  return true;
}

void CommandLifecycle::wait_for(const Result<api::Ticket>& ticket, bool setting) {
  if (!taken(ticket, setting)) return;
  progress_ = Progress::kWaiting;
  ticket_ = *ticket;
  setting_ = setting;
}

void CommandLifecycle::done_with(const Result<api::Ticket>& ticket) {
  if (taken(ticket, true)) done();
}

void CommandLifecycle::latch_error(std::string reason) {
  if (reason.empty()) reason = "The robot gives no reason.";
  spdlog::warn("{}: {} {}: {}", name_, latest_.name.value_or("no command"), latest_.command_id,
               reason);
  error_ = reason;
  latest_.description = std::move(reason);
}

// Beside what there was to tell of its target.
void CommandLifecycle::add_description(const std::string& text) {
  if (latest_.description) {
    *latest_.description += "; " + text;
  } else {
    latest_.description = text;
  }
}

}  // namespace aprsim::protocols
