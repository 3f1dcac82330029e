#include "protocols/messages/preview_message.hpp"

#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "protocols/messages/control_request.hpp"
#include "protocols/messages/enum_match.hpp"
#include "protocols/messages/write_message.hpp"

namespace aprsim::protocols {
namespace {

std::chrono::nanoseconds span_of(double seconds) {
  return std::chrono::nanoseconds(std::llround(seconds * 1e9));
}

Result<void> check_speed(const char* field, double value, const char* unit) {
  if (std::isfinite(value) && value > 0) return {};
  return fail(ErrorCode::kInvalidArgument, field,
              fmt::format("{} {} is not a speed above 0", value, unit));
}

Result<api::RobotAction> tool_move(const v1::PreviewMoveRequest& request) {
  const auto pose = pose_of(request.tool_in_reference());
  if (!pose) return tl::unexpected(pose.error());
  api::MoveTo move{*pose, request.straight()};
  if (request.has_speed_m_s()) {
    if (auto ok = check_speed("speed_m_s", request.speed_m_s(), "m/s"); !ok) {
      return tl::unexpected(ok.error());
    }
    move.limits.trans_speed = api::LimitSetting{.relative = false, .value = request.speed_m_s()};
  }
  return move;
}

Result<api::RobotAction> joint_move(const v1::PreviewMoveRequest& request,
                                    const api::RobotDescription& robot) {
  const v1::PreviewJoints& joints = request.joints();
  if (joints.positions_rad_size() != static_cast<int>(robot.joints.size())) {
    return fail(ErrorCode::kInvalidArgument, "positions_rad",
                fmt::format("{} values, but {} has {} joints", joints.positions_rad_size(),
                            robot.name, robot.joints.size()));
  }
  if (request.straight()) {
    return fail(ErrorCode::kInvalidArgument, "straight",
                "true is only valid for a pose of the tool, not for joints");
  }
  std::optional<double> speed;
  if (joints.has_speed_rad_s()) {
    speed = joints.speed_rad_s();
    if (auto ok = check_speed("speed_rad_s", *speed, "rad/s"); !ok) {
      return tl::unexpected(ok.error());
    }
  }
  api::MoveJoints move;
  for (int i = 0; i < joints.positions_rad_size(); ++i) {
    move.targets.push_back({i, joints.positions_rad(i), speed, std::nullopt});
  }
  return move;
}

Result<api::RobotAction> move_of(const v1::PreviewMoveRequest& request,
                                 const api::RobotDescription& robot) {
  switch (request.target_case()) {
    case v1::PreviewMoveRequest::kToolInReference:
      return tool_move(request);
    case v1::PreviewMoveRequest::kJoints:
      return joint_move(request, robot);
    case v1::PreviewMoveRequest::TARGET_NOT_SET:
      break;
  }
  return fail(ErrorCode::kInvalidArgument, "target",
              "one of tool_in_reference and joints must be set");
}

}  // namespace

Result<api::PreviewRequest> to_preview(const v1::PreviewMoveRequest& request,
                                       const api::CellDescription& cell) {
  const auto robot = robot_named(request.robot(), cell);
  if (!robot) return tl::unexpected(robot.error());
  const int mode = static_cast<int>(request.mode());
  if (mode < 0 || mode > v1::PlanningMode_MAX) {
    return fail(ErrorCode::kInvalidArgument, "mode",
                fmt::format("{} is not a planning mode; expected direct, check or avoid", mode));
  }
  auto move = move_of(request, cell.robots[static_cast<std::size_t>(*robot)]);
  if (!move) return tl::unexpected(move.error());
  api::PreviewRequest out{.command = {*robot, *std::move(move)}, .mode = {}};
  if (mode != v1::PLANNING_MODE_UNSPECIFIED) out.mode = *from_message<api::PlanningMode>(mode);
  return out;
}

void write_message(const api::MovePreview& preview, v1::PreviewMoveResponse& message) {
  message.set_epoch(preview.epoch);
  message.set_step(preview.step);
  write_message(preview.time, *message.mutable_sim_time());
  message.set_possible(preview.refusal.empty());
  message.set_refusal(preview.refusal);
  message.set_mode(static_cast<v1::PlanningMode>(to_message(preview.mode)));
  if (preview.touch) {
    auto& touch = *message.mutable_touch();
    touch.set_mover(preview.touch->mover);
    touch.set_other(preview.touch->other);
    write_message(preview.touch->p_R, *touch.mutable_position_m());
    write_message(span_of(preview.touch->time_s), *touch.mutable_time());
  }
  write_message(span_of(preview.delay_s), *message.mutable_delay());
  write_message(span_of(preview.duration_s), *message.mutable_duration());
  message.set_length_m(preview.length_m);
  write_message(span_of(preview.spacing_s), *message.mutable_spacing());
  for (const api::PreviewPoint& point : preview.points) {
    auto& out = *message.add_points();
    out.mutable_joints_rad()->Assign(point.joints.begin(), point.joints.end());
    write_message(point.p_RT, *out.mutable_tool_m());
  }
}

}  // namespace aprsim::protocols
