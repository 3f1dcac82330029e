#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "world/api/values/pose.hpp"
#include "world/api/values/wire_joint.hpp"

/// Motion commands of a robot.
namespace aprsim::api {

/// One limit of the tool's motion: absolute [m/s, m/s^2, rad/s, rad/s^2], or relative as a fraction
/// 0..1 of the robot's maximum.
struct LimitSetting {
  bool relative = false;
  double value = 0;
};

/// Limits for the motion to one pose; SetMotionLimit sets the absent ones.
struct PoseLimits {
  std::optional<LimitSetting> trans_speed{}, trans_accel{}, rot_speed{}, rot_accel{};
};

/// How near a pose must be passed: distances along the axes of R, angles of the tool's x and z
/// axes. The robot's own defaults replace absent values.
struct PoseTolerance {
  std::optional<double> x_m{}, y_m{}, z_m{}, x_axis_rad{}, z_axis_rad{};

  static constexpr bool kUnbounded = true;  ///< see world/archive/archive.hpp
};

/// Moves the tool frame T to a pose in the robot's reference frame R (the frame of CRCL poses).
struct MoveTo {
  Pose X_RT;
  bool straight = false;  ///< straight line of the tool point with shortest rotation; else free
  PoseLimits limits{};
  PoseTolerance tolerance{};  ///< an arm that is pushed aside by more has not arrived
  bool may_touch = false;     ///< not checked against the surroundings, whatever the mode
};

inline constexpr std::size_t kMaxWaypoints = 1000;
inline constexpr double kMaxPath_m = 100;  ///< from the first waypoint to the last
struct Waypoint {
  Pose X_RT;
  PoseLimits limits{};        ///< for the way to it
  PoseTolerance tolerance{};  ///< for passing it; the last one's is as in MoveTo
};
/// Moves the tool past every waypoint within its tolerance and ends at the last one, without
/// stopping in between unless a tolerance leaves no room.
struct MoveThroughTo {
  std::vector<Waypoint> waypoints;
  bool straight = false;  ///< straight between the waypoints; else free

  /// See world/archive/archive.hpp.
  template <typename In>
  void require_valid(In& in) const {
    in.require(!waypoints.empty() && waypoints.size() <= kMaxWaypoints, "a path without waypoints");
  }
};

/// Moves freely to `start`, then along the tool's z axis by `free_m`, then on a helix: the tool
/// turns by `turn_rad` about its own z axis, or about the parallel to it through `axis_point_R`,
/// while it advances along it by `screw_m`. Positive: away from the robot, right-handed about z.
struct MoveScrew {
  std::optional<Waypoint> start{};
  std::optional<Eigen::Vector3d> axis_point_R{};
  double free_m = 0, screw_m = 0, turn_rad = 0;
};

/// Drives a joint by torque instead of speed.
struct JointTorque {
  double setting_nm = 0;              ///< magnitude against what it meets, > 0
  std::optional<double> rate_nm_s{};  ///< builds up so fast; absent = at once
};

struct JointTarget {
  int joint = 0;  ///< 0-based
  double position_rad = 0;
  std::optional<double> speed_rad_s;
  std::optional<double> accel_rad_s2;
  /// Moves towards the position until it is reached or an obstacle balances the torque.
  std::optional<JointTorque> torque{};
  /// A joint that is pushed aside by more has not arrived.
  std::optional<double> tolerance_rad{};
  /// Added to the position: shares of where these joints would be held if none were named.
  std::vector<JointShare> held{};

  /// See world/archive/archive.hpp.
  template <typename In>
  void require_valid(In& in) const {
    in.joint(joint);
    for (const JointShare& share : held) in.joint(share.joint);
  }
};
/// Moves the named joints, each with its own optional speed and acceleration; joints that are not
/// named hold their present target.
struct MoveJoints {
  std::vector<JointTarget> targets;
  bool may_touch = false;  ///< as of MoveTo

  /// See world/archive/archive.hpp.
  template <typename In>
  void require_valid(In& in) const {
    in.require(!targets.empty(), "a move of no joints");
  }
};

}  // namespace aprsim::api
