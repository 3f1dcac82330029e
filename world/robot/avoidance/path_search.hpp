#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "world/robot/avoidance/collision_checker.hpp"
#include "world/robot/trajectory/profile/joint_limits.hpp"

namespace aprsim::robot {

/// Effort of a search for a path.
struct PathSearchEffort {
  int iterations = 1500;  ///< of the planner, for each attempt
  int attempts = 3;       ///< each with numbers of its own; the shortest path counts
  /// Length beside the straight line at which a path is good enough; 0 makes all attempts.
  double good_length = 1.3;
  int shortcuts = 60;  ///< tries to shorten each path
  /// Postures that are measured, at most; a few more where a motion is being checked.
  std::size_t evaluations = 60'000;
  std::uint64_t seed = 1;
};

/// A search for a path of postures from one to another. Distances in joint space count each joint
/// with its longest lever, so that they bound the travel of the arm's points [m].
class PathSearch {
 public:
  /// The arguments must outlive it. Ends soon after `cancelled`, if any, has become true.
  PathSearch(CollisionChecker& checker, const JointLimits& limits,
             const std::atomic<bool>* cancelled = nullptr);

  /// The postures of a free path, with both ends; empty where none is found. The checker's ends are
  /// set. RRT-Connect (Kuffner & LaValle 2000) of OMPL, then shortcuts. The result depends on the
  /// arguments alone: no clock, no random numbers but its own.
  [[nodiscard]] std::vector<JointVector> find(const JointVector& start, const JointVector& goal,
                                              const PathSearchEffort& effort);
  /// Length of a path of postures, in that measure [m].
  [[nodiscard]] double length(const std::vector<JointVector>& path) const;

 private:
  [[nodiscard]] std::vector<JointVector> connect(const JointVector& start, const JointVector& goal,
                                                 int iterations, std::uint64_t seed);
  [[nodiscard]] bool ended() const;
  void shorten(std::vector<JointVector>& path, int tries, std::uint64_t seed);
  void drop_postures(std::vector<JointVector>& path);
  [[nodiscard]] double distance(const JointVector& a, const JointVector& b) const;

  CollisionChecker& checker_;
  const JointLimits& limits_;
  const std::atomic<bool>* cancelled_;
  JointVector weights_;
  std::size_t last_evaluation_ = 0;
};

}  // namespace aprsim::robot
