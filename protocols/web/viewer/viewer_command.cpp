#include "protocols/web/viewer/viewer_command.hpp"

#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "protocols/messages/control_request.hpp"
#include "protocols/messages/enum_match.hpp"
#include "protocols/web/jog/manual_mode.hpp"
#include "protocols/web/jog/robot_ready.hpp"
#include "world/api/commands/stop_command.hpp"

namespace aprsim::web {
namespace {

using Body = protocols::CommandBody;
using Bodies = Result<std::vector<Body>>;

Bodies one(Body body) { return std::vector<Body>{std::move(body)}; }

Bodies one_of(Result<Body> command) {
  return std::move(command).map([](Body body) { return std::vector<Body>{std::move(body)}; });
}

Bodies move_of(const v1::MoveTool& move, int index) {
  const auto pose = protocols::pose_of(move.tool_in_reference());
  if (!pose) return tl::unexpected(pose.error());
  api::MoveTo action{*pose, move.straight()};
  if (move.has_speed()) {
    const auto limits = manual_limits(move.speed());
    if (!limits) return tl::unexpected(limits.error());
    action.limits = *limits;
  }
  return one(api::RobotCommand{index, std::move(action)});
}

Bodies joints_of(const v1::MoveJoints& move, const api::RobotDescription& robot, int index) {
  if (move.positions_rad_size() != static_cast<int>(robot.joints.size())) {
    return fail(ErrorCode::kInvalidArgument, "positions_rad",
                fmt::format("{} values, but {} has {} joints", move.positions_rad_size(),
                            robot.name, robot.joints.size()));
  }
  if (!(move.speed() > 0 && move.speed() <= 1)) {
    return fail(ErrorCode::kInvalidArgument, "speed",
                fmt::format("{} is not above 0 and up to 1", move.speed()));
  }
  api::MoveJoints action;
  for (int i = 0; i < move.positions_rad_size(); ++i) {
    const auto& joint = robot.joints[static_cast<std::size_t>(i)];
    action.targets.push_back(
        {i, move.positions_rad(i), move.speed() * joint.max_speed_rad_s, std::nullopt});
  }
  return one(api::RobotCommand{index, std::move(action)});
}

Bodies planning_of(v1::PlanningMode mode, int index) {
  if (mode <= v1::PLANNING_MODE_UNSPECIFIED || mode > v1::PlanningMode_MAX) {
    return fail(ErrorCode::kInvalidArgument, "planning",
                fmt::format("{} is not a planning mode", static_cast<int>(mode)));
  }
  return one(api::RobotCommand{
      index, api::SetPlanning{*protocols::from_message<api::PlanningMode>(mode)}});
}

Bodies robot_commands(const v1::RobotRequest& request, const api::Snapshot& snapshot) {
  const api::CellDescription& cell = *snapshot.cell;
  if (request.robot() >= cell.robots.size()) {
    return fail(ErrorCode::kNotFound, "robot",
                fmt::format("{} is not below {}, the robots of this cell", request.robot(),
                            cell.robots.size()));
  }
  const int index = static_cast<int>(request.robot());
  const bool moves = request.has_move_tool() || request.has_move_joints() || request.has_gripper();
  const auto ready = check_ready(snapshot.robots[request.robot()]);
  if (moves && !ready) return tl::unexpected(ready.error());
  switch (request.action_case()) {
    case v1::RobotRequest::kInitialize:
      return one(api::RobotCommand{index, api::InitRobot{}});
    case v1::RobotRequest::kStop:
      return one(api::RobotCommand{index, api::StopMotion{api::StopKind::kFast}});
    case v1::RobotRequest::kMoveTool:
      return move_of(request.move_tool(), index);
    case v1::RobotRequest::kMoveJoints:
      return joints_of(request.move_joints(), cell.robots[request.robot()], index);
    case v1::RobotRequest::kGripper:
      return one(api::RobotCommand{index, api::SetGripper{request.gripper().setting()}});
    case v1::RobotRequest::kPlanning:
      return planning_of(request.planning(), index);
    case v1::RobotRequest::ACTION_NOT_SET:
      break;
  }
  return fail(ErrorCode::kInvalidArgument, "action", "no action is set");
}

std::vector<Body> stop_cell(const api::CellDescription& cell) {
  std::vector<Body> all;
  for (int robot = 0; robot < static_cast<int>(cell.robots.size()); ++robot) {
    all.emplace_back(api::RobotCommand{robot, api::StopMotion{api::StopKind::kFast}});
  }
  api::ConveyorCommand belt;
  belt.run = false;
  if (cell.has_conveyor) all.emplace_back(belt);
  return all;
}

}  // namespace

Result<api::PreviewRequest> preview_of(const v1::RobotRequest& request,
                                       const api::Snapshot& snapshot) {
  if (!request.has_move_tool() && !request.has_move_joints()) {
    return fail(ErrorCode::kInvalidArgument, "action", "only move_tool and move_joints have one");
  }
  auto commands = robot_commands(request, snapshot);
  if (!commands) return tl::unexpected(commands.error());
  return api::PreviewRequest{std::get<api::RobotCommand>(std::move(commands->front())), {}};
}

std::optional<Bodies> commands_of(const v1::ViewerRequest& request, const api::Snapshot& snapshot) {
  switch (request.body_case()) {
    case v1::ViewerRequest::kPause:
      return one_of(protocols::command_of(request.pause(), snapshot));
    case v1::ViewerRequest::kResume:
      return one_of(protocols::command_of(request.resume(), snapshot));
    case v1::ViewerRequest::kStep:
      if (!snapshot.paused) {
        return fail(ErrorCode::kFailedPrecondition, "step",
                    "the cell is running; pause it before stepping");
      }
      return one_of(protocols::to_command(request.step()).map([](api::StepBy step) -> Body {
        return api::SimulationCommand(step);
      }));
    case v1::ViewerRequest::kSetSpeed:
      return one_of(protocols::command_of(request.set_speed(), snapshot));
    case v1::ViewerRequest::kReset:
      return one_of(protocols::command_of(request.reset(), snapshot));
    case v1::ViewerRequest::kSaveState:
      return one_of(protocols::command_of(request.save_state(), snapshot));
    case v1::ViewerRequest::kLoadState:
      return one_of(protocols::command_of(request.load_state(), snapshot));
    case v1::ViewerRequest::kConveyor:
      return one_of(protocols::command_of(request.conveyor(), snapshot));
    case v1::ViewerRequest::kIntruder:
      return one_of(protocols::command_of(request.intruder(), snapshot));
    case v1::ViewerRequest::kInjectFault:
      return one_of(protocols::command_of(request.inject_fault(), snapshot));
    case v1::ViewerRequest::kEndFault:
      return one_of(protocols::command_of(request.end_fault(), snapshot));
    case v1::ViewerRequest::kReportEvent:
      return one_of(protocols::command_of(request.report_event(), snapshot));
    case v1::ViewerRequest::kStopCell:
      return stop_cell(*snapshot.cell);
    case v1::ViewerRequest::kRobot:
      return robot_commands(request.robot(), snapshot);
    default:
      return std::nullopt;
  }
}

bool is_stop(const v1::ViewerRequest& request) {
  if (request.has_pause() || request.has_stop_cell() || request.robot().has_stop()) return true;
  if (!request.has_conveyor()) return false;
  const v1::SetConveyorRequest& belt = request.conveyor();
  api::ConveyorCommand command;
  if (belt.has_run()) command.run = belt.run();
  if (belt.has_emergency_stop()) command.emergency_stop = belt.emergency_stop();
  command.fault_reset = belt.fault_reset();
  return api::is_stop(command);
}

}  // namespace aprsim::web
