#include "protocols/messages/control_request.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "protocols/messages/codecs.hpp"

namespace aprsim::protocols {
namespace {

constexpr std::uint64_t kMaxSteps = 10'000'000;

std::vector<std::string> saved_names(const api::Snapshot& snapshot) {
  std::vector<std::string> names;
  if (!snapshot.saved_states) return names;
  for (const api::SavedState& state : snapshot.saved_states->states) names.push_back(state.name);
  return names;
}

Result<void> find_state(const std::string& name, const api::Snapshot& snapshot) {
  const auto names = saved_names(snapshot);
  if (std::ranges::find(names, name) != names.end()) return {};
  return fail(ErrorCode::kNotFound, "name",
              fmt::format("no state is saved as '{}'; {}{}", name.substr(0, 64),
                          names.empty() ? "none is saved" : "there are: ", fmt::join(names, ", ")));
}

/// For requests whose numbers are checked where the command is submitted.
template <typename T, typename Request>
T plain(const Request& request) {
  T command;
  static_cast<void>(read_fields(request, command));  // texts and poses can always be read
  return command;
}

}  // namespace

Result<int> robot_named(const std::string& name, const api::CellDescription& cell) {
  const auto robot = std::ranges::find(cell.robots, name, &api::RobotDescription::name);
  if (robot != cell.robots.end()) return static_cast<int>(robot - cell.robots.begin());
  std::vector<std::string> names;
  for (const api::RobotDescription& each : cell.robots) names.push_back(each.name);
  return fail(ErrorCode::kNotFound, "robot",
              fmt::format("no robot is named '{}'; there are: {}", name.substr(0, 64),
                          fmt::join(names, ", ")));
}

Result<Pose> pose_of(const v1::Pose& message) {
  const auto& p = message.position_m();
  const auto& q = message.orientation();
  Pose pose;
  pose.p = {p.x(), p.y(), p.z()};
  pose.q = {q.w(), q.x(), q.y(), q.z()};
  if (!(std::abs(pose.q.norm() - 1) < 1e-3)) {
    return fail(ErrorCode::kInvalidArgument, "orientation",
                fmt::format("the quaternion has length {}, expected 1", pose.q.norm()));
  }
  pose.q.normalize();
  return pose;
}

Result<api::StepBy> to_command(const v1::StepRequest& request) {
  const std::uint64_t steps = std::max<std::uint64_t>(request.steps(), 1);
  if (steps > kMaxSteps) {
    return fail(ErrorCode::kInvalidArgument, "steps",
                fmt::format("{} is more than {}", steps, kMaxSteps));
  }
  return api::StepBy{steps};
}

Result<void> Codec<api::RunUntil>::read(const v1::RunUntilRequest& message, api::RunUntil& run) {
  auto read = read_fields(message, run);
  if (message.max_steps() == 0) run.steps = api::kMaxRunSteps;
  return read;
}

Result<api::RunUntil> to_command(const v1::RunUntilRequest& request) {
  api::RunUntil run;
  return read_value(request, run).map([&] { return std::move(run); });
}

Result<CommandBody> command_of(const v1::SetSpeedRequest& request,
                               const api::Snapshot& /*snapshot*/) {
  switch (request.speed_case()) {
    case v1::SetSpeedRequest::kFactor:
      if (!(request.factor() >= api::kMinSpeed && request.factor() <= api::kMaxSpeed)) {
        return fail(ErrorCode::kInvalidArgument, "factor",
                    fmt::format("{} is not within {} and {}", request.factor(), api::kMinSpeed,
                                api::kMaxSpeed));
      }
      return api::SimulationCommand(api::SetSpeed{request.factor()});
    case v1::SetSpeedRequest::kMaximum:
      if (!request.maximum()) {
        return fail(ErrorCode::kInvalidArgument, "maximum",
                    "only true is valid; set factor for any other speed");
      }
      return api::SimulationCommand(api::SetSpeed{});
    case v1::SetSpeedRequest::SPEED_NOT_SET:
      break;
  }
  return fail(ErrorCode::kInvalidArgument, "speed", "one of factor and maximum must be set");
}

Result<CommandBody> command_of(const v1::SetPlanningRequest& request,
                               const api::Snapshot& snapshot) {
  const auto robot = robot_named(request.robot(), *snapshot.cell);
  if (!robot) return tl::unexpected(robot.error());
  const int mode = static_cast<int>(request.mode());
  if (mode <= v1::PLANNING_MODE_UNSPECIFIED || mode > v1::PlanningMode_MAX) {
    return fail(ErrorCode::kInvalidArgument, "mode",
                fmt::format("{} is not a planning mode; expected direct, check or avoid", mode));
  }
  return api::RobotCommand{*robot, api::SetPlanning{*from_message<api::PlanningMode>(mode)}};
}

Result<CommandBody> command_of(const v1::SetIntruderRequest& request,
                               const api::Snapshot& /*snapshot*/) {
  const auto& intruder = request.intruder();
  if (request.has_intruder() && !(intruder.has_intruder_in_world() && intruder.has_size_m())) {
    return fail(ErrorCode::kInvalidArgument, "intruder",
                "intruder_in_world and size_m must both be set");
  }
  return plain<api::SetIntruder>(request);
}

Result<api::FollowTrajectory> to_command(const v1::FollowTrajectory& message) {
  api::FollowTrajectory goal;
  if (auto ok = read_value(message, goal); !ok) return tl::unexpected(ok.error());
  return goal;
}

Result<api::AppendPoints> to_command(const v1::AppendPoints& message) {
  api::AppendPoints points;
  if (auto ok = read_value(message, points); !ok) return tl::unexpected(ok.error());
  return points;
}

Result<CommandBody> command_of(const v1::SetConveyorRequest& request,
                               const api::Snapshot& snapshot) {
  const api::CellDescription& cell = *snapshot.cell;
  if (!cell.has_conveyor) {
    return fail(ErrorCode::kFailedPrecondition, "conveyor",
                "scene '" + cell.scene + "' has no conveyor");
  }
  api::ConveyorCommand command;
  if (request.has_run()) command.run = request.run();
  switch (request.direction()) {
    case v1::CONVEYOR_DIRECTION_UNSPECIFIED:
      break;
    case v1::CONVEYOR_DIRECTION_FORWARD:
      command.forward = true;
      break;
    case v1::CONVEYOR_DIRECTION_REVERSE:
      command.forward = false;
      break;
    default:
      return fail(ErrorCode::kInvalidArgument, "direction",
                  fmt::format("{} is no ConveyorDirection", static_cast<int>(request.direction())));
  }
  if (request.has_speed_m_s()) {
    const double speed = request.speed_m_s();
    if (!std::isfinite(speed) || speed < 0 || speed > cell.conveyor.max_speed_m_s) {
      return fail(
          ErrorCode::kInvalidArgument, "speed_m_s",
          fmt::format("{} m/s is not within 0 and {} m/s", speed, cell.conveyor.max_speed_m_s));
    }
    command.speed_m_s = speed;
  }
  if (request.has_emergency_stop()) command.emergency_stop = request.emergency_stop();
  command.fault_reset = request.fault_reset();
  return command;
}

Result<CommandBody> command_of(const v1::ResumeRequest& /*request*/,
                               const api::Snapshot& snapshot) {
  if (snapshot.world_fault.empty()) return api::SimulationCommand(api::Resume{});
  return fail(ErrorCode::kFailedPrecondition, "resume",
              "the simulation has stopped until the cell is reset: " + snapshot.world_fault);
}

Result<CommandBody> command_of(const v1::SaveStateRequest& request, const api::Snapshot& snapshot) {
  const auto names = saved_names(snapshot);
  const bool again = std::ranges::find(names, request.name()) != names.end();
  if (!again && names.size() >= api::kMaxSavedStates) {
    return fail(ErrorCode::kFailedPrecondition, "name",
                fmt::format("'{}' cannot be saved: all {} places for saved states are taken; use "
                            "one of their names again, or delete one",
                            request.name().substr(0, 64), api::kMaxSavedStates));
  }
  return api::SimulationCommand(api::SaveState{request.name()});
}

Result<CommandBody> command_of(const v1::LoadStateRequest& request, const api::Snapshot& snapshot) {
  if (auto ok = find_state(request.name(), snapshot); !ok) return tl::unexpected(ok.error());
  return api::SimulationCommand(api::LoadState{request.name()});
}

Result<CommandBody> command_of(const v1::DeleteStateRequest& request,
                               const api::Snapshot& snapshot) {
  if (auto ok = find_state(request.name(), snapshot); !ok) return tl::unexpected(ok.error());
  return api::SimulationCommand(api::DeleteState{request.name()});
}

Result<CommandBody> command_of(const v1::PauseRequest& /*request*/,
                               const api::Snapshot& /*snapshot*/) {
  return api::SimulationCommand(api::Pause{});
}

Result<CommandBody> command_of(const v1::ResetRequest& request, const api::Snapshot& /*snapshot*/) {
  const bool empty = request.scene_name().empty() && request.scene_text().empty();
  if (request.scene_case() != v1::ResetRequest::SCENE_NOT_SET && empty) {
    return fail(ErrorCode::kInvalidArgument, "scene", "it is empty");
  }
  api::Reset reset;
  if (request.has_seed()) reset.seed = request.seed();
  reset.scene_name = request.scene_name();
  reset.scene_text = request.scene_text();
  return api::SimulationCommand(std::move(reset));
}

Result<CommandBody> command_of(const v1::SpawnBodyRequest& request,
                               const api::Snapshot& /*snapshot*/) {
  return api::SceneCommand(plain<api::SpawnBody>(request));
}

Result<CommandBody> command_of(const v1::MoveBodyRequest& request,
                               const api::Snapshot& /*snapshot*/) {
  return api::SceneCommand(plain<api::MoveBody>(request));
}

Result<CommandBody> command_of(const v1::RemoveBodyRequest& request,
                               const api::Snapshot& /*snapshot*/) {
  return api::SceneCommand(plain<api::RemoveBody>(request));
}

Result<CommandBody> command_of(const v1::SetSceneValueRequest& request,
                               const api::Snapshot& /*snapshot*/) {
  return api::SceneCommand(plain<api::SetSceneValue>(request));
}

Result<CommandBody> command_of(const v1::SetSignalsRequest& request,
                               const api::Snapshot& /*snapshot*/) {
  return plain<api::SetSignals>(request);
}

Result<CommandBody> command_of(const v1::EndFaultRequest& request,
                               const api::Snapshot& /*snapshot*/) {
  return api::FaultCommand(api::EndFault{request.id()});
}

Result<CommandBody> command_of(const v1::ReportEventRequest& request,
                               const api::Snapshot& /*snapshot*/) {
  return api::FaultCommand(api::ReportEvent{request.event()});
}

}  // namespace aprsim::protocols
