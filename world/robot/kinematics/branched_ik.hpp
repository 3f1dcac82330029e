#pragma once

#include <array>
#include <string>
#include <vector>

#include "world/robot/kinematics/inverse_kinematics.hpp"

namespace aprsim::robot {

/// Common part of all solvers: choice of a branch, full turns, limits, the wording
/// of a refusal. A family only lists its branches.
class BranchedIk : public InverseKinematics {
 public:
  [[nodiscard]] std::vector<IkSolution> all(const Eigen::Isometry3d& X_BF,
                                            double elbow_rad) const override;
  [[nodiscard]] Result<JointVector> nearest(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                            double elbow_rad) const override;
  /// A redundant arm gives its own.
  [[nodiscard]] double elbow_of(const JointVector& /*q*/) const override { return 0; }
  /// A redundant arm searches: search_elbow().
  [[nodiscard]] Result<double> choose_elbow(const Eigen::Isometry3d& X_BF,
                                            const JointVector& seed) const override;

  static constexpr int kMostBranches = 16;
  /// A pose tilted by less out of those that the axes allow counts as one of them [rad].
  static constexpr double kTiltTolerance_rad = 1e-4;

  /// The joint vectors of all branches, each angle modulo full turns and regardless of limits.
  struct Branches {
    std::array<JointVector, kMostBranches> q;
    int count = 0;
    double excess_m = 0;  ///< when count is 0: how far beyond (> 0) or within (< 0) the reach
    double limit_m = 0;   ///< then that reach, from the shoulder to the wrist's centre; 0 = unknown
    double tilt_rad = 0;  ///< when count is 0: the pose's tilt, which the arm's axes do not allow
  };

  /// `seed` decides angles that a singularity leaves free.
  [[nodiscard]] virtual Branches branches(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                          double elbow_rad) const = 0;

 protected:
  /// The best branch at one elbow angle, or how the least bad one fails.
  struct Choice {
    bool found = false;
    JointVector q;
    double cost = 0;       ///< squared distance to the seed, in joint ranges
    double excess_m = 0;   ///< not 0: out of reach
    double limit_m = 0;    ///< then the reach
    double tilt_rad = 0;   ///< not 0: tilted out of the poses that the axes allow
    int joint = -1;        ///< joint farthest outside its limits ...
    double angle_rad = 0;  ///< ... at this angle
    double violation_rad = 0;
  };

  explicit BranchedIk(const ArmModel& model);

  [[nodiscard]] Choice choose(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                              double elbow_rad) const;
  [[nodiscard]] Error refusal(const Choice& failed) const;
  /// choose_elbow() of a redundant arm: a scan of the circle from the seed's own elbow angle, and a
  /// refinement of the best angle. Where no angle of the scan is within limits, searches between
  /// them for narrower ranges that are.
  [[nodiscard]] Result<double> search_elbow(const Eigen::Isometry3d& X_BF,
                                            const JointVector& seed) const;
  [[nodiscard]] int dof() const { return static_cast<int>(ranges_.size()); }
  /// Position in its range: -1 lower limit .. 1 upper limit.
  [[nodiscard]] double relative_position(int joint, double q) const;

 private:
  struct Range {
    std::string name;
    double lower = 0, upper = 0;
    bool prismatic = false;
  };

  [[nodiscard]] double fit(int joint, double angle, double seed) const;
  [[nodiscard]] double violation(int joint, double q) const;
  [[nodiscard]] double posture_cost(const Choice& choice) const;
  [[nodiscard]] static double shortfall(const Choice& choice);
  [[nodiscard]] Choice least_violation(const Eigen::Isometry3d& X_BF, const JointVector& seed,
                                       double middle, double half, double& elbow) const;
  void add_turns(const JointVector& base, std::vector<IkSolution>& out) const;

  std::vector<Range> ranges_;
};

}  // namespace aprsim::robot
