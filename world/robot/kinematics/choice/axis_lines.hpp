#pragma once

#include <initializer_list>
#include <optional>
#include <vector>

#include "world/robot/kinematics/families/placed_ik.hpp"
#include "world/robot/model/arm_model.hpp"

/// An arm as the lines of its axes at the zero posture, which do not depend on how its description
/// chooses frames (product of exponentials: Lynch & Park 2017, ch. 4).
namespace aprsim::robot {

inline constexpr double kLineTolerance = 1e-7;  ///< of directions, and of distances [m]

struct AxisLine {
  Eigen::Vector3d direction, point;  ///< in base axes, the direction of length 1
};

[[nodiscard]] std::vector<AxisLine> axis_lines(const ArmModel& model);

[[nodiscard]] bool are_parallel(const AxisLine& a, const AxisLine& b);
[[nodiscard]] bool are_orthogonal(const AxisLine& a, const AxisLine& b);

/// The point in which all lines meet; none where they do not, or are all parallel.
[[nodiscard]] std::optional<Eigen::Vector3d> meeting_point(std::initializer_list<AxisLine> lines);

/// An arm of a family with its own frames and angles: one joint an entry, limits empty.
class CanonicalArm {
 public:
  /// Axis and offset from the joint before, in the family's axes at its zero posture.
  void add(const Eigen::Vector3d& axis, const Eigen::Vector3d& offset, double sign, double zero,
           bool prismatic = false);

  /// Completes the placement with the flange of `model`, and checks on random postures that both
  /// arms then move alike; none where they do not.
  [[nodiscard]] std::optional<Placement> match(const ArmModel& model,
                                               const Eigen::Isometry3d& X_BA) const;

 private:
  ArmModel chain_;
  std::vector<double> sign_, zero_;
};

}  // namespace aprsim::robot
