#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "crcl/values.hpp"

/// The commands that move and stop the arm; see crcl/commands.hpp.
namespace aprsim::crcl {

enum class StopCondition { kImmediate, kFast, kNormal };
struct StopMotion {
  StopCondition condition = StopCondition::kNormal;
  bool operator==(const StopMotion&) const = default;
};

/// The settings that PoseAndSetType adds to a pose; they hold for that move only.
struct PoseSettings {
  bool coordinated = false;
  std::optional<Rate> trans_speed, rot_speed, trans_accel, rot_accel;
  std::optional<PoseTolerance> tolerance;
  bool operator==(const PoseSettings&) const = default;
};
/// PoseType, or PoseAndSetType when it has settings.
struct Waypoint {
  Pose pose;
  std::optional<PoseSettings> settings;
  bool operator==(const Waypoint&) const = default;
};
struct MoveTo {
  bool straight = false;
  Waypoint end;  ///< EndPosition
  bool operator==(const MoveTo&) const = default;
};
struct MoveThroughTo {
  bool straight = false;
  std::vector<Waypoint> waypoints;  ///< NumPositions is their number
  bool operator==(const MoveThroughTo&) const = default;
};
struct MoveScrew {
  std::optional<Waypoint> start;      ///< StartPosition
  std::optional<Vector> axis_point;   ///< AxisPoint
  std::optional<double> free_travel;  ///< AxialDistanceFree
  double screw_travel = 0;            ///< AxialDistanceScrew
  double turn = 0;
  bool operator==(const MoveScrew&) const = default;
};

struct JointSpeedAccel {
  std::optional<double> speed, accel;
  bool operator==(const JointSpeedAccel&) const = default;
};
struct JointForceTorque {
  std::optional<double> setting, change_rate;
  bool operator==(const JointForceTorque&) const = default;
};
struct ActuateJoint {
  int joint = 0;  ///< 1-based
  double position = 0;
  std::variant<JointSpeedAccel, JointForceTorque> details;
  bool operator==(const ActuateJoint&) const = default;
};
struct ActuateJoints {
  std::vector<ActuateJoint> joints;
  std::vector<JointTolerance> tolerances;  ///< JointTolerances; empty when absent
  bool operator==(const ActuateJoints&) const = default;
};

}  // namespace aprsim::crcl
