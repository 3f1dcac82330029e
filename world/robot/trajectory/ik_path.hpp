#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "world/api/error.hpp"
#include "world/robot/kinematics/inverse_kinematics.hpp"
#include "world/robot/trajectory/tool_path.hpp"

namespace aprsim::robot {

/// What follows a path: the arm and its inverse kinematics. Never part of a state that is saved.
struct ArmGeometry {
  const ArmModel& model;
  const InverseKinematics& ik;
};

/// The joint path that follows a tool path exactly, on one branch of the inverse kinematics.
/// trace() samples the whole of it, densely where the joints turn fast, so that a path that leaves
/// the joint limits, the reach or the branch is known before anything moves; at() then solves the
/// inverse kinematics anew for any point, seeded from the samples. A copyable value. Thread: sim.
class IkPath {
 public:
  struct Sample {
    double u = 0;
    JointVector q, slope;          ///< slope = dq/du
    JointVector curvature;         ///< d2q/du2
    JointVector third_derivative;  ///< d3q/du3
  };
  /// How to follow the tool path: u = s / length. The elbow of a redundant arm turns evenly from
  /// its start by `elbow_turn_rad`.
  struct Route {
    double elbow_start_rad = 0, elbow_turn_rad = 0;
    JointVector start;  ///< posture at u = 0
  };

  /// Of a path of one segment; longer paths take more, and memory when they are planned.
  static constexpr std::size_t kMaxSamples = 4000;

  IkPath();

  /// The path to trace, of the frame T that is fixed to the flange at X_FT.
  [[nodiscard]] ToolPath& tool() { return tool_; }
  [[nodiscard]] const ToolPath& tool() const { return tool_; }
  void set_tool_frame(const Eigen::Isometry3d& X_FT) { X_TF_ = X_FT.inverse(); }

  /// Errors: kUnreachable with the joint, value, limit and place on the path.
  [[nodiscard]] Result<void> trace(const ArmGeometry& arm, const Route& route);
  /// Joint position at u after a successful trace(). Exact, but for the places where a joint
  /// touches its limit between two samples: there it is interpolated and held at the limit.
  [[nodiscard]] JointVector at(const ArmGeometry& arm, double u) const;
  /// Joint position at u, interpolated between the samples: quick, good to some 1e-6 rad.
  [[nodiscard]] JointVector interpolate(double u) const;
  /// Whether a few points of the route can be reached without a change of branch: a quick look
  /// before trace().
  [[nodiscard]] bool looks_passable(const ArmGeometry& arm, const Route& route);
  [[nodiscard]] std::span<const Sample> samples() const { return samples_; }
  [[nodiscard]] const Route& route() const { return route_; }
  /// The line's branch leaves the start posture only after a turn of joints that are free there
  /// (a singular start): the posture it needs. Set by a trace() that failed at u = 0.
  [[nodiscard]] bool singular_start() const { return singular_start_; }
  [[nodiscard]] const JointVector& needed_start() const { return needed_start_; }

 private:
  [[nodiscard]] Result<JointVector> solve(const ArmGeometry& arm, double u,
                                          const JointVector& seed) const;
  [[nodiscard]] JointVector predict(double u) const;
  [[nodiscard]] tl::unexpected<Error> blocked(const ArmGeometry& arm, double u) const;
  [[nodiscard]] const JointVector& posture_before(double u) const;
  void find_needed_start(const ArmGeometry& arm);
  void thin();
  void differentiate();

  ToolPath tool_;
  Eigen::Isometry3d X_TF_ = Eigen::Isometry3d::Identity();
  Route route_;
  double length_ = 1;  ///< s at u = 1
  std::vector<Sample> samples_;
  bool singular_start_ = false;
  JointVector needed_start_;
};

/// Fills in the derivatives of samples whose u and q are there.
void differentiate_samples(std::span<IkPath::Sample> samples);

}  // namespace aprsim::robot
