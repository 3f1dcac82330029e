#pragma once

#include <cstddef>
#include <vector>

/// How the controller of a robot counts its joints towards clients, where that is not the arm's own
/// way: which joint has which number, the unit, the sense, the zero and which joints go together.
namespace aprsim::api {

inline constexpr std::size_t kMaxWireJoints = 8;

/// A share of another joint's angle.
struct JointShare {
  int joint = 0;  ///< 0-based
  double factor = 1;
};

/// Bounds of an angle.
struct AngleRange {
  double lower_rad = 0, upper_rad = 0;
};

/// One joint as clients count it. Its angle is its value in the unit: counts of the drive over
/// `counts_per_rad`, or an angle in the connection's unit. The arm's joint is then at
/// sign * angle + offset_rad + the couplings' shares of the angles of other wire joints.
struct WireJoint {
  int joint = -1;                     ///< of the arm, 0-based; -1: a number that no joint has
  double counts_per_rad = 0;          ///< above 0: counts of the drive; 0: an angle
  double sign = 1;                    ///< 1 or -1
  double offset_rad = 0;              ///< of the arm's joint
  std::vector<JointShare> couplings;  ///< of wire joints
  /// Limits of the angle that the robot reports and enforces; empty (both 0) = those that the arm's
  /// limits give.
  AngleRange range{};

  [[nodiscard]] bool has_range() const { return range.lower_rad < range.upper_rad; }
};

}  // namespace aprsim::api
