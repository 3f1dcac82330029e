#include "world/cell/commands/command_check.hpp"

#include <cmath>
#include <cstdio>
#include <string>

#include "world/api/description/robot_identity.hpp"
#include "world/base/utf8.hpp"
#include "world/devices/input_check.hpp"
#include "world/faults/fault_check.hpp"

namespace aprsim::world {
namespace {

constexpr double kFar = 1000, kLargestIntruder = 10;  // m

tl::unexpected<Error> bad(std::string field, std::string message) {
  return fail(ErrorCode::kInvalidArgument, std::move(field), std::move(message));
}

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

Result<void> finite(double value, const char* field) {
  if (std::isfinite(value)) return {};
  return bad(field, std::string(field) + " is " + std::to_string(value) + ", not a finite number");
}

Result<void> positive(double value, const char* field) {
  if (std::isfinite(value) && value > 0) return {};
  return bad(field, std::string(field) + " is " + std::to_string(value) + ", must be above 0");
}

Result<void> not_negative(double value, const char* field) {
  if (value >= 0) return {};
  return bad(field, std::string(field) + " is " + std::to_string(value) + ", must be 0 or more");
}

Result<void> unit(const Eigen::Quaterniond& q) {
  if (q.coeffs().allFinite() && std::abs(q.norm() - 1) <= 1e-6) return {};
  return bad("rotation", "the rotation is not a unit quaternion");
}

Result<void> check_pose(const Pose& X_RT) {
  for (int i = 0; i < 3; ++i) {
    if (auto ok = finite(X_RT.p[i], "position"); !ok) return ok;
  }
  return unit(X_RT.q);
}

Result<void> check_limit(const api::LimitSetting& limit) {
  if (auto ok = positive(limit.value, limit.relative ? "fraction" : "setting"); !ok) return ok;
  if (limit.relative && limit.value > 1) {
    return bad("fraction", "fraction is " + std::to_string(limit.value) + ", must be at most 1");
  }
  return {};
}

Result<void> check_limits(const api::PoseLimits& limits) {
  for (const auto& limit :
       {limits.trans_speed, limits.trans_accel, limits.rot_speed, limits.rot_accel}) {
    if (!limit) continue;
    if (auto ok = check_limit(*limit); !ok) return ok;
  }
  return {};
}

Result<void> check_waypoint(const api::Waypoint& point) {
  if (auto ok = check_pose(point.X_RT); !ok) return ok;
  if (auto ok = check_limits(point.limits); !ok) return ok;
  const api::PoseTolerance& t = point.tolerance;
  for (const auto& value : {t.x_m, t.y_m, t.z_m, t.x_axis_rad, t.z_axis_rad}) {
    if (!value) continue;
    if (auto ok = not_negative(*value, "tolerance"); !ok) return ok;
  }
  return {};
}

Result<void> check_action(const api::MoveTo& move, const api::RobotDescription&) {
  return check_waypoint({move.X_RT, move.limits, move.tolerance});
}

Result<void> check_action(const api::MoveThroughTo& move, const api::RobotDescription&) {
  if (move.waypoints.empty()) return bad("waypoints", "no waypoint is given");
  if (move.waypoints.size() > api::kMaxWaypoints) {
    return bad("waypoints", "there are " + std::to_string(move.waypoints.size()) +
                                " waypoints, the limit is " + std::to_string(api::kMaxWaypoints));
  }
  for (std::size_t i = 0; i < move.waypoints.size(); ++i) {
    if (auto ok = check_waypoint(move.waypoints[i]); !ok) {
      return bad(ok.error().field, "waypoint " + std::to_string(i + 1) + ": " + ok.error().message);
    }
  }
  double length_m = 0;
  for (std::size_t i = 1; i < move.waypoints.size(); ++i) {
    length_m += (move.waypoints[i].X_RT.p - move.waypoints[i - 1].X_RT.p).norm();
  }
  if (length_m > api::kMaxPath_m) {
    return bad("waypoints", "the path past them is " + text_of(length_m) +
                                " m long, the limit is " + text_of(api::kMaxPath_m) + " m");
  }
  return {};
}

Result<void> check_action(const api::MoveScrew& screw, const api::RobotDescription&) {
  if (screw.start) {
    if (auto ok = check_waypoint(*screw.start); !ok) return ok;
  }
  if (screw.axis_point_R && !screw.axis_point_R->allFinite()) {
    return bad("axis point", "the axis point is not a number");
  }
  if (auto ok = finite(screw.free_m, "free distance"); !ok) return ok;
  if (auto ok = finite(screw.screw_m, "screw distance"); !ok) return ok;
  return finite(screw.turn_rad, "turn");
}

Result<void> check_action(const api::SetOverride& set, const api::RobotDescription&) {
  if (set.fraction >= 0 && set.fraction <= 1) return {};
  return bad("override", "speed override is " + std::to_string(set.fraction) +
                             " of full speed, must be within 0 to 1");
}

Result<void> check_action(const api::MoveJoints& move, const api::RobotDescription& robot) {
  const int dof = static_cast<int>(robot.joints.size());
  if (move.targets.empty()) return bad("targets", "no joint is named");
  for (const auto& target : move.targets) {
    if (target.joint < 0 || target.joint >= dof) {
      return bad("joint", "joint " + std::to_string(target.joint + 1) + " does not exist; " +
                              robot.name + " has joints 1 to " + std::to_string(dof));
    }
    if (auto ok = finite(target.position_rad, "position"); !ok) return ok;
    for (const api::JointShare& share : target.held) {
      if (share.joint < 0 || share.joint >= dof) {
        return bad("held joint", "held joint " + std::to_string(share.joint + 1) +
                                     " does not exist; " + robot.name + " has joints 1 to " +
                                     std::to_string(dof));
      }
      if (auto ok = finite(share.factor, "share of a held joint"); !ok) return ok;
    }
    if (target.speed_rad_s) {
      if (auto ok = positive(*target.speed_rad_s, "speed"); !ok) return ok;
    }
    if (target.accel_rad_s2) {
      if (auto ok = positive(*target.accel_rad_s2, "acceleration"); !ok) return ok;
    }
    if (target.tolerance_rad) {
      if (auto ok = not_negative(*target.tolerance_rad, "joint tolerance"); !ok) return ok;
    }
    if (!target.torque) continue;
    if (auto ok = positive(target.torque->setting_nm, "torque"); !ok) return ok;
    if (target.torque->rate_nm_s) {
      if (auto ok = positive(*target.torque->rate_nm_s, "torque change rate"); !ok) return ok;
    }
  }
  return {};
}

Result<void> check_gripper(double setting) {
  if (setting >= 0 && setting <= 1) return {};
  return bad("setting", "setting is " + std::to_string(setting) + ", must be within 0 to 1");
}

Result<void> check_action(const api::SetGripper& set, const api::RobotDescription&) {
  return check_gripper(set.setting);
}

Result<void> check_action(const api::SetGripperForce& set, const api::RobotDescription& robot) {
  if (set.force_n > 0 && set.force_n <= robot.gripper.force_n) return {};
  return bad("force", "gripper force is " + std::to_string(set.force_n) +
                          " N, must be above 0 and at most " +
                          std::to_string(robot.gripper.force_n) + " N");
}

Result<void> check_action(const api::Dwell& dwell, const api::RobotDescription&) {
  if (dwell.duration.count() >= 0) return {};
  return bad("duration", "dwell time is negative");
}

Result<void> check_action(const api::SetMotionLimit& set, const api::RobotDescription&) {
  return check_limit({set.relative, set.value});
}

template <typename Action>
Result<void> check_action(const Action&, const api::RobotDescription&) {
  return {};
}

Result<void> check_guards(const std::vector<api::Guard>& guards) {
  if (guards.size() > api::kMaxGuards) {
    return bad("guards", std::to_string(guards.size()) + " guards, must be at most " +
                             std::to_string(api::kMaxGuards));
  }
  for (const auto& guard : guards) {
    if (auto ok = finite(guard.value, "guard limit"); !ok) return ok;
    const bool change =
        guard.limit == api::GuardLimit::kIncreased || guard.limit == api::GuardLimit::kDecreased;
    if (change) {
      if (auto ok = positive(guard.value, "guard limit"); !ok) return ok;
    }
    if (guard.recheck.count() < 0) return bad("guard recheck time", "recheck time is negative");
  }
  return {};
}

Result<void> check_body(const api::RobotCommand& command, const CellNames& cell) {
  if (command.robot < 0 || command.robot >= static_cast<int>(cell->robots.size())) {
    return bad("robot", "robot " + std::to_string(command.robot) +
                            " does not exist; the cell has " + std::to_string(cell->robots.size()));
  }
  const auto& robot = cell->robots[static_cast<std::size_t>(command.robot)];
  if (auto ok = check_guards(command.guards); !ok) return ok;
  return std::visit([&](const auto& action) { return check_action(action, robot); },
                    command.action);
}

// ---- streams of joint motions

Result<void> check_all_finite(const std::vector<double>& values, const char* field) {
  for (const double value : values) {
    if (auto ok = finite(value, field); !ok) return ok;
  }
  return {};
}

Result<void> check_points(const std::vector<api::TrajectoryPoint>& points) {
  if (points.size() > api::kMaxTrajectoryPoints) {
    return bad("points", "there are " + std::to_string(points.size()) + " points, the limit is " +
                             std::to_string(api::kMaxTrajectoryPoints));
  }
  for (const api::TrajectoryPoint& point : points) {
    for (const auto& [values, field] :
         {std::pair{&point.position_rad, "position"}, std::pair{&point.velocity_rad_s, "velocity"},
          std::pair{&point.acceleration_rad_s2, "acceleration"}}) {
      if (auto ok = check_all_finite(*values, field); !ok) return ok;
    }
  }
  return {};
}

Result<void> check_commander(const std::string& name) {
  if (!name.empty() && name.size() <= api::kMaxCommanderName && utf8::is_valid(name)) return {};
  return bad("commander", "a name of " + std::to_string(name.size()) +
                              " bytes, must be UTF-8 text of 1 to " +
                              std::to_string(api::kMaxCommanderName));
}

Result<void> check_tolerances(const std::vector<api::JointTolerance>& tolerances,
                              const char* field) {
  if (tolerances.size() > static_cast<std::size_t>(api::kMaxJoints)) {
    return bad(field, std::to_string(tolerances.size()) + " tolerances, the limit is " +
                          std::to_string(api::kMaxJoints));
  }
  for (const api::JointTolerance& tolerance : tolerances) {
    for (const double value : {tolerance.position_rad, tolerance.velocity_rad_s}) {
      if (auto ok = finite(value, field); !ok) return ok;
      if (auto ok = not_negative(value, field); !ok) return ok;
    }
  }
  return {};
}

Result<void> check_stream(const api::ClaimMotion& claim) {
  return check_commander(claim.commander);
}

Result<void> check_stream(const api::AppendPoints& append) { return check_points(append.points); }

Result<void> check_stream(const api::AppendMove& move) {
  if (auto ok = check_all_finite(move.position_rad, "position"); !ok) return ok;
  if (!(move.speed > 0 && move.speed <= 1)) {
    return bad("speed", "speed is " + std::to_string(move.speed) +
                            " of full speed, must be above 0 and at most 1");
  }
  if (!(move.rounding >= 0 && move.rounding <= 1)) {
    return bad("rounding",
               "rounding is " + std::to_string(move.rounding) + ", must be within 0 to 1");
  }
  if (move.max_waiting >= 1 && move.max_waiting <= api::kMaxWaitingMoves) return {};
  return bad("max_waiting", std::to_string(move.max_waiting) + " moves, must be 1 to " +
                                std::to_string(api::kMaxWaitingMoves));
}

Result<void> check_stream(const api::FollowTrajectory& follow) {
  if (auto ok = check_commander(follow.commander); !ok) return ok;
  if (follow.joint_names.size() > static_cast<std::size_t>(api::kMaxJoints)) {
    return bad("joint_names", std::to_string(follow.joint_names.size()) + " names, the limit is " +
                                  std::to_string(api::kMaxJoints));
  }
  for (const std::string& name : follow.joint_names) {
    if (!utf8::is_valid(name)) return bad("joint_names", "a name is no UTF-8 text");
  }
  if (auto ok = check_tolerances(follow.path_tolerance, "path_tolerance"); !ok) return ok;
  if (auto ok = check_tolerances(follow.goal_tolerance, "goal_tolerance"); !ok) return ok;
  if (follow.goal_time_tolerance < SimTime(0) ||
      follow.goal_time_tolerance > api::kMaxTrajectoryTime) {
    return bad("goal_time_tolerance", "goal time tolerance is " +
                                          text_of(seconds(follow.goal_time_tolerance)) +
                                          " s, must be within 0 to 14400");
  }
  return check_points(follow.points);
}

Result<void> check_stream(const api::SwitchGripper& set) { return check_gripper(set.setting); }

template <typename Action>
Result<void> check_stream(const Action&) {
  return {};
}

Result<void> check_body(const api::TrajectoryCommand& command, const CellNames& cell) {
  if (command.robot < 0 || command.robot >= static_cast<int>(cell->robots.size())) {
    return bad("robot", "robot " + std::to_string(command.robot) +
                            " does not exist; the cell has " + std::to_string(cell->robots.size()));
  }
  return std::visit([](const auto& action) { return check_stream(action); }, command.action);
}

Result<void> check_body(const api::ConveyorCommand& command, const CellNames& cell) {
  if (!cell->has_conveyor) {
    return fail(ErrorCode::kNotFound, "conveyor", "scene " + cell->scene + " has no conveyor");
  }
  if (command.speed_m_s && !(std::isfinite(*command.speed_m_s) && *command.speed_m_s >= 0)) {
    return bad("speed", "speed is " + std::to_string(*command.speed_m_s) +
                            " m/s; give a magnitude and a direction");
  }
  if (command.watchdog_s && !(std::isfinite(*command.watchdog_s) && *command.watchdog_s >= 0)) {
    return bad("watchdog", "watchdog time is " + std::to_string(*command.watchdog_s) +
                               " s, must be 0 (off) or more");
  }
  return {};
}

Result<void> check_body(const api::SetIntruder& command, const CellNames&) {
  if (!command.intruder) return {};
  const auto& [X_WI, size] = *command.intruder;
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(X_WI.p[i]) <= kFar)) {
      return bad("position",
                 "position is " + std::to_string(X_WI.p[i]) + " m, must be within -1000 to 1000");
    }
    if (!(size[i] > 0 && size[i] <= kLargestIntruder)) {
      return bad("size",
                 "size is " + std::to_string(size[i]) + " m, must be above 0 and at most 10");
    }
  }
  return unit(X_WI.q);
}

Result<void> check_body(const api::SetSignals& command, const CellNames& cell) {
  return devices::check_settings(command, cell->devices);
}

Result<void> check_body(api::FaultCommand& command, const CellNames& cell) {
  if (auto* inject = std::get_if<api::InjectFault>(&command)) {
    auto spec = resolve(*inject, *cell);
    if (!spec) return tl::unexpected(spec.error());
    inject->resolved = std::make_shared<const ResolvedFault>(ResolvedFault{cell, *std::move(spec)});
  }
  const auto* report = std::get_if<api::ReportEvent>(&command);
  return report ? check_event(report->event) : Result<void>{};
}

/// Checks the pose of a body.
Result<void> check_place(const Pose& X_WB) {
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(X_WB.p[i]) <= kFar)) {
      return bad("position",
                 "position is " + std::to_string(X_WB.p[i]) + " m, must be within -1000 to 1000");
    }
  }
  return unit(X_WB.q);
}

Result<void> check_text(const std::string& text, std::size_t most, const char* field) {
  if (!text.empty() && text.size() <= most) return {};
  return bad(field, std::to_string(text.size()) + " bytes, must have 1 to " + std::to_string(most));
}

Result<void> check_body(const api::SceneCommand& command, const CellNames& cell) {
  if (const auto* spawn = std::get_if<api::SpawnBody>(&command)) {
    if (auto ok = check_text(spawn->name, api::kMaxSceneText, "name"); !ok) return ok;
    if (std::ranges::find(cell->body_types, spawn->type) == cell->body_types.end()) {
      std::string types;
      for (const auto& type : cell->body_types) types += (types.empty() ? "" : ", ") + type;
      return fail(ErrorCode::kNotFound, "type",
                  "'" + spawn->type.substr(0, api::kMaxSceneText) +
                      "' is no type of gears or trays; there are: " + types);
    }
    return check_place(spawn->X_WB);
  }
  if (const auto* move = std::get_if<api::MoveBody>(&command)) {
    if (auto ok = check_text(move->name, api::kMaxSceneText, "name"); !ok) return ok;
    return check_place(move->X_WB);
  }
  if (const auto* remove = std::get_if<api::RemoveBody>(&command)) {
    return check_text(remove->name, api::kMaxSceneText, "name");
  }
  const auto& set = std::get<api::SetSceneValue>(command);
  if (auto ok = check_text(set.path, api::kMaxScenePath, "path"); !ok) return ok;
  return check_text(set.value, api::kMaxSceneValue, "value");
}

Result<void> check_name(const std::string& name) {
  // Lists have a line for each name.
  const bool printable = std::ranges::none_of(
      name, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; });
  if (!printable) return bad("name", "a name with control characters, must be one line of text");
  if (!name.empty() && name.size() <= api::kMaxStateName) return {};
  return bad("name", "a name of " + std::to_string(name.size()) + " bytes, must have 1 to " +
                         std::to_string(api::kMaxStateName));
}

Result<void> check_run(api::RunUntil& run, const CellNames& cell) {
  if (run.steps < 1 || run.steps > api::kMaxRunSteps) {
    return bad("max_steps", std::to_string(run.steps) + " steps, must be 1 to " +
                                std::to_string(api::kMaxRunSteps));
  }
  if (const auto* crossing = std::get_if<api::WhenCrossing>(&run.until)) {
    const auto robot = resolve(*crossing, *cell);
    if (!robot) return tl::unexpected(robot.error());
    run.resolved = std::make_shared<const ResolvedCrossing>(ResolvedCrossing{cell, *robot});
  }
  return {};
}

Result<void> check_body(api::SimulationCommand& command, const CellNames& cell) {
  const auto* set = std::get_if<api::SetSpeed>(&command);
  if (set && set->factor && !(*set->factor >= api::kMinSpeed && *set->factor <= api::kMaxSpeed)) {
    return bad("factor", "factor is " + text_of(*set->factor) + ", must be within " +
                             text_of(api::kMinSpeed) + " to " + text_of(api::kMaxSpeed));
  }
  if (auto* run = std::get_if<api::RunUntil>(&command)) return check_run(*run, cell);
  if (const auto* save = std::get_if<api::SaveState>(&command)) return check_name(save->name);
  if (const auto* load = std::get_if<api::LoadState>(&command)) return check_name(load->name);
  if (const auto* gone = std::get_if<api::DeleteState>(&command)) return check_name(gone->name);
  return {};
}

}  // namespace

Result<void> check(api::Command& command, const CellNames& cell) {
  return std::visit([&](auto& body) { return check_body(body, cell); }, command.body);
}

Result<void> check_addressee(const api::Command& command, const CellNames& now) {
  int index = -1;
  if (const auto* robot = std::get_if<api::RobotCommand>(&command.body)) index = robot->robot;
  if (const auto* motion = std::get_if<api::TrajectoryCommand>(&command.body)) {
    index = motion->robot;
  }
  if (index < 0 || !command.cell || command.cell == now) return {};
  const auto place = static_cast<std::size_t>(index);
  const api::RobotDescription& meant = command.cell->robots.at(place);
  if (place < now->robots.size() && api::same_robot(meant, now->robots[place])) return {};
  return fail(ErrorCode::kUnavailable, "robot",
              "the robot " + meant.name + " has left the cell, or its place in the scene");
}

}  // namespace aprsim::world
