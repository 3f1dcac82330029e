#include "protocols/crcl/robot_link.hpp"

#include <chrono>
#include <type_traits>
#include <utility>
#include <variant>

#include <spdlog/spdlog.h>

#include "crcl/text.hpp"
#include "protocols/crcl/robot_action.hpp"
#include "protocols/crcl/status_report.hpp"

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

// Commands that begin, end or stop, which no state forbids.
bool is_always_admitted(const crcl::CommandBody& body) {
  return std::holds_alternative<crcl::InitCanon>(body) ||
         std::holds_alternative<crcl::EndCanon>(body) ||
         std::holds_alternative<crcl::StopMotion>(body);
}

}  // namespace

// Carries out one admitted command.
struct RobotLink::Executor {
  RobotLink& link;
  ReportSettings& settings;
  const std::string& peer;

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

  void operator()(const crcl::MoveTo& move) const { submit(to_action(move, settings)); }
  void operator()(const crcl::MoveThroughTo& move) const {
    submit(to_action(move, settings, link.tolerances_.intermediate));
  }
  void operator()(const crcl::MoveScrew& screw) const { submit(to_action(screw, settings)); }
  void operator()(const crcl::OpenToolChanger&) const {
    submit(Result<api::SetToolChanger>({.open = true}));
  }
  void operator()(const crcl::CloseToolChanger&) const {
    submit(Result<api::SetToolChanger>({.open = false}));
  }

  void operator()(const crcl::ActuateJoints& command) const { submit(command_to_joints(command)); }
  void operator()(const crcl::SetEndEffector& set) const {
    link.wait_for(link.commander_.submit(to_action(set)), false);
  }
  void operator()(const crcl::Dwell& dwell) const { submit(to_action(dwell)); }

  void operator()(const crcl::SetRate& set) const {
    const Result<api::SetMotionLimit> action = to_action(set.which, set.rate, settings);
    if (!action) return link.hold(action.error().message);
    link.wait_for(link.commander_.submit(*action), true);
  }

  void operator()(const crcl::Message& message) const {
    spdlog::info("{}: message from {}: {}", link.name_, peer, message.text);
    link.done(crcl::shorten(message.text, kMaxDescriptionBytes));
  }

  void operator()(const crcl::SetEndPoseTolerance& set) const {
    link.tolerances_.end = in_si(set.tolerance, settings.units());
    link.done();
  }
  void operator()(const crcl::SetIntermediatePoseTolerance& set) const {
    link.tolerances_.intermediate = in_si(set.tolerance, settings.units());
    link.done();
  }
  void operator()(const crcl::SetDefaultJointTolerances& set) const {
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

  void operator()(const crcl::EnableSensor& command) const {
    settle(link.curtain_.enable(command, *link.source_.latest()->cell));
  }
  void operator()(const crcl::DisableSensor& command) const {
    settle(link.curtain_.disable(command, *link.source_.latest()->cell));
  }

  template <typename Other>
  void operator()(const Other&) const {
    not_implemented();
  }

  void not_implemented(const std::string& what = "") const {
    link.hold(*link.latest_.name + what + " not implemented.");
  }

 private:
  Result<api::MoveJoints> command_to_joints(const crcl::ActuateJoints& command) const {
    const api::SnapshotPtr snapshot = link.source_.latest();
    const auto& robot = snapshot->cell->robots[static_cast<std::size_t>(link.robot_)];
    return to_action(command, settings, static_cast<int>(robot.joints.size()));
  }

  template <typename Action>
  void submit(const Result<Action>& action) const {
    if (!action) return link.hold(action.error().message);
    link.wait_for(link.commander_.submit(*action), false);
  }

  void settle(const Result<void>& outcome) const {
    if (!outcome) return link.hold(outcome.error().message);
    link.done();
  }

  template <typename Configuration>
  void configure(const Configuration& configuration) const {
    settings.apply(configuration);
    link.done();
  }
};

RobotLink::RobotLink(int robot, api::EndpointId endpoint, api::CommandSink& sink,
                     const api::SnapshotSource& source)
    : robot_(robot), source_(source), commander_(robot, endpoint, sink) {
  const api::SnapshotPtr snapshot = source_.latest();
  name_ = "crcl." + snapshot->cell->robots[static_cast<std::size_t>(robot)].name;
  epoch_ = snapshot->epoch;
  latest_.command_id = -1;
}

void RobotLink::execute(const crcl::CommandInstance& instance, ReportSettings& settings,
                        const std::string& peer) {
  refresh(*source_.latest());
  const crcl::Command& command = instance.command;
  begin(std::string(crcl::type_name(command.body)), instance);
  spdlog::debug("{}: {} {} from {}", name_, *latest_.name, command.id, peer);
  if (!admits(command.body)) return;
  const Executor executor{*this, settings, peer};
  if (!command.guards.empty() && !is_always_admitted(command.body)) {
    return executor.not_implemented(" with Guard");
  }
  std::visit(executor, command.body);
}

void RobotLink::refuse(const std::string& type, std::int64_t id, const std::string& reason) {
  refresh(*source_.latest());
  crcl::CommandInstance instance;
  instance.command.id = id;
  begin(type, instance);
  if (!error_) hold(reason);
}

void RobotLink::bad_document(const std::string& reason) {
  refresh(*source_.latest());
  if (session_ == Session::kOpen) {
    const auto stopped = commander_.submit(api::StopMotion{api::StopKind::kFast});
    if (!stopped) spdlog::error("{}: cannot stop: {}", name_, stopped.error().message);
  }
  if (!error_) hold(reason);
}

void RobotLink::begin(const std::string& type, const crcl::CommandInstance& instance) {
  latest_.name = type;
  latest_.command_id = instance.command.id;
  latest_.description.reset();
  latest_.program_file = instance.program_file;
  latest_.program_index = instance.program_index;
  latest_.program_length = instance.program_length;
  if (error_) latest_.description = "In error until InitCanon: " + *error_;
}

bool RobotLink::admits(const crcl::CommandBody& body) {
  if (is_always_admitted(body)) return true;
  const bool harmless = is_local(body) || std::holds_alternative<crcl::Message>(body);
  const bool in_session = session_ == Session::kOpen || (session_ == Session::kEnded && harmless);
  if (!in_session) {
    if (!error_) {
      hold("Not initialized when cmd=" + *latest_.name + " received. Send InitCanon first.");
    }
    return false;
  }
  return !error_ || is_local(body);
}

void RobotLink::done(std::optional<std::string> description) {
  progress_ = Progress::kDone;
  if (!error_) latest_.description = std::move(description);
}

void RobotLink::wait_for(const Result<api::Ticket>& ticket, bool setting) {
  if (!ticket) return hold(*latest_.name + " not taken: " + ticket.error().message);
  progress_ = Progress::kWaiting;
  ticket_ = *ticket;
  setting_ = setting;
}

void RobotLink::hold(std::string reason) {
  if (reason.empty()) reason = "The robot gives no reason.";
  spdlog::warn("{}: {} {}: {}", name_, latest_.name.value_or("no command"), latest_.command_id,
               reason);
  error_ = reason;
  latest_.description = std::move(reason);
}

void RobotLink::refresh(const api::Snapshot& snapshot) {
  const api::RobotSnapshot& robot = snapshot.robots[static_cast<std::size_t>(robot_)];
  if (snapshot.epoch != epoch_) {
    epoch_ = snapshot.epoch;
    session_ = Session::kNever;
    since_ = 0;
    commander_.forget();
    error_.reset();
    const bool interrupted = std::exchange(progress_, Progress::kReady) == Progress::kWaiting;
    latest_.description = "The cell was reset.";
    if (interrupted) hold("The cell was reset before " + *latest_.name + " ended.");
  }
  const bool current = robot.action.ticket >= since_ && snapshot.applied >= since_;
  const bool failed = robot.action.state == api::ActionState::kError || robot.protective_stop;
  if (current && failed && !error_) hold(robot.action.description);
  if (progress_ == Progress::kWaiting) follow(snapshot);
}

void RobotLink::follow(const api::Snapshot& snapshot) {
  const api::ActionStatus& action = snapshot.robots[static_cast<std::size_t>(robot_)].action;
  if (action.ticket < ticket_ && !(setting_ && snapshot.applied >= ticket_)) return;
  if (setting_ || (action.ticket == ticket_ && action.state == api::ActionState::kDone)) {
    progress_ = Progress::kDone;
  } else if (action.ticket > ticket_ && !error_) {
    progress_ = Progress::kDone;
    hold(*latest_.name + " was replaced by a command from another interface.");
  }
}

crcl::CommandStatus RobotLink::command_status() {
  crcl::CommandStatus status = latest_;
  if (error_) {
    status.state = crcl::CommandState::kError;
  } else if (progress_ == Progress::kWaiting) {
    status.state = crcl::CommandState::kWorking;
  } else {
    status.state =
        progress_ == Progress::kDone ? crcl::CommandState::kDone : crcl::CommandState::kReady;
  }
  return status;
}

crcl::Status RobotLink::status(const ReportSettings& settings) {
  const api::SnapshotPtr snapshot = source_.latest();
  refresh(*snapshot);
  ++latest_.status_id;
  const auto index = static_cast<std::size_t>(robot_);
  const api::RobotSnapshot& robot = snapshot->robots[index];
  const api::RobotDescription& description = snapshot->cell->robots[index];
  crcl::Status status;
  status.command = command_status();
  if (settings.sections().joints) {
    status.joints = joint_statuses(robot, static_cast<int>(description.joints.size()), settings);
  }
  if (settings.sections().pose) status.pose = pose_status(robot, settings);
  if (settings.sections().gripper) status.gripper = gripper_status(robot, description, settings);
  if (settings.sections().settings) {
    status.settings = settings_status(*snapshot, robot_, commander_, tolerances_, settings);
  }
  if (settings.sections().sensors) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    status.sensors = curtain_.statuses(
        *snapshot, std::chrono::duration_cast<std::chrono::milliseconds>(now).count(),
        settings.units());
  }
  return status;
}

}  // namespace aprsim::protocols
