#pragma once

#include <atomic>
#include <cstddef>
#include <span>
#include <vector>

#include "world/base/result.hpp"
#include "world/robot/kinematics/inverse_kinematics.hpp"
#include "world/robot/trajectory/path/joint_guide.hpp"
#include "world/robot/trajectory/path/path_sample.hpp"
#include "world/robot/trajectory/path/tool_path.hpp"

namespace aprsim::robot {

/// An arm and its inverse kinematics, as motions need them each step. Never part of a saved state.
struct ArmGeometry {
  const ArmModel& model;
  const InverseKinematics& ik;
  /// Planning ends soon after this has become true; null = never.
  const std::atomic<bool>* cancel = nullptr;
  /// Set where a search over all postures of a redundant arm would help, which is then not made;
  /// null = it is made.
  bool* search_wanted = nullptr;
  /// Whether to search over all postures, which takes tens of milliseconds.
  [[nodiscard]] bool may_search() const {
    if (search_wanted != nullptr) *search_wanted = true;
    return search_wanted == nullptr;
  }
  [[nodiscard]] bool cancelled() const {
    return cancel != nullptr && cancel->load(std::memory_order_relaxed);
  }
};
/// The outcome of planning that was cancelled.
[[nodiscard]] inline tl::unexpected<Error> given_up() {
  return fail(ErrorCode::kUnavailable, "planning", "planning was given up");
}

/// The joint path of a tool path, exact: on one branch of the inverse kinematics, or, of a
/// redundant arm, the nearest to a guide through joint space. trace() samples the whole of it,
/// densely where the joints turn fast, so that a path that leaves the joint limits, the reach or
/// the branch is known before anything moves; at() then solves the inverse kinematics again for any
/// point, seeded from the samples. A copyable value. Thread: sim.
class IkPath {
 public:
  /// The start and, for a redundant arm, its freedom over u = s / length: the elbow angle turns
  /// evenly from its start by `elbow_turn_rad`, or the arm stays near a guide, which may pass
  /// postures with aligned axes.
  struct Route {
    double elbow_start_rad = 0, elbow_turn_rad = 0;
    JointVector start;  ///< posture at u = 0
    JointGuide guide{};

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [elbow_start_rad, elbow_turn_rad, start, guide] = self;
      io(elbow_start_rad, elbow_turn_rad, start, guide);
    }
  };

  /// The path to trace, of the frame T that is fixed to the flange at X_FT.
  [[nodiscard]] ToolPath& tool() { return tool_; }
  [[nodiscard]] const ToolPath& tool() const { return tool_; }
  [[nodiscard]] const Eigen::Isometry3d& X_TF() const { return X_TF_; }
  void set_tool_frame(const Eigen::Isometry3d& X_FT) { X_TF_ = X_FT.inverse(); }

  /// Errors: kUnreachable with the joint, value, limit and place on the path.
  [[nodiscard]] Result<void> trace(const ArmGeometry& arm, const Route& route);
  /// Joint position at u after a successful trace(). Exact, but for the places where a joint
  /// touches its limit between two samples: there it is interpolated and held at the limit.
  [[nodiscard]] JointVector at(const ArmGeometry& arm, double u) const;
  /// Joint position at u, interpolated between the samples: quick, good to some 1e-6 rad.
  [[nodiscard]] JointVector interpolate(double u) const;
  /// Whether a few points of the route can be reached without a change of branch: a quick test
  /// before trace().
  [[nodiscard]] bool seems_feasible(const ArmGeometry& arm, const Route& route);
  [[nodiscard]] std::span<const PathSample> samples() const { return samples_; }
  /// Allocated memory, besides the value itself.
  [[nodiscard]] std::size_t bytes() const {
    return tool_.bytes() + route_.guide.bytes() + bytes_of(samples_);
  }
  /// Whether at() can be called.
  [[nodiscard]] bool is_complete() const { return !samples_.empty() && tool_.is_complete(); }
  /// How far the last trace() came.
  [[nodiscard]] double reached() const { return samples_.back().u; }
  /// The start posture is singular, and the path's branch begins at another posture of the same
  /// pose, required_start(). Set by a trace() that failed at u = 0.
  [[nodiscard]] bool singular_start() const { return singular_start_; }
  [[nodiscard]] const JointVector& required_start() const { return required_start_; }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [tool, X_TF, route, length, samples, singular_start, required_start] = self;
    io(tool, X_TF, route, length, samples, singular_start, required_start);
  }
  template <typename In>
  void require_valid(In& in) const {
    for (const PathSample& sample : samples_) {
      in.all_joints(sample.q.size());
      in.all_joints(sample.slope.size());
    }
  }

 private:
  [[nodiscard]] Result<JointVector> solve(const ArmGeometry& arm, double u,
                                          const JointVector& seed) const;
  [[nodiscard]] Result<JointVector> near_guide(const ArmGeometry& arm, double u,
                                               const Eigen::Isometry3d& X_BF) const;
  [[nodiscard]] JointVector extrapolate(double u) const;
  [[nodiscard]] tl::unexpected<Error> refusal(const ArmGeometry& arm, double u) const;
  [[nodiscard]] const JointVector& posture_before(double u) const;
  void find_required_start(const ArmGeometry& arm);
  void drop_close_samples();
  void differentiate();

  ToolPath tool_;
  Eigen::Isometry3d X_TF_ = Eigen::Isometry3d::Identity();
  Route route_;
  double length_ = 1;  ///< s at u = 1
  std::vector<PathSample> samples_;
  bool singular_start_ = false;
  JointVector required_start_;
};

}  // namespace aprsim::robot
