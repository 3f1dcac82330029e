#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "world/base/result.hpp"
#include "world/robot/avoidance/obstacle_tree.hpp"
#include "world/robot/avoidance/posture_curve.hpp"
#include "world/robot/avoidance/surroundings.hpp"
#include "world/robot/model/arm_model.hpp"

namespace aprsim::robot {

/// Something of an arm that comes too near to something.
struct Touch {
  std::string mover, other;
  double distance_m = 0;                          ///< negative: so deep
  double u = 0;                                   ///< where on the curve
  Eigen::Vector3d p_B = Eigen::Vector3d::Zero();  ///< middle of the mover's shape
};

/// Distances of an arm and what it carries from its surroundings and from itself, for the moves
/// from one posture to another. Everything must keep the clearance. A pair that is nearer at the
/// start or the goal may come as near as it is there; a pair that touches there has to part
/// steeply, but for a gripper and a part. Motions are checked as a whole: a piece is free when no
/// shape can travel as far in it as the distance from its middle allows (conservative advancement:
/// Mirtich 1996), so that nothing is passed through, however thin. Thread: one at a time.
class CollisionChecker {
 public:
  /// The arguments must outlive it.
  CollisionChecker(const ArmModel& model, const Surroundings& around);

  /// The ends of the moves that are checked from now on. Errors: kFailedPrecondition, which of both
  /// is blocked, and what touches what there.
  [[nodiscard]] Result<void> set_ends(const JointVector& start, const JointVector& goal);

  /// The touch that blocks an end: u = 0 at the start, 1 at the goal. None = neither is blocked.
  [[nodiscard]] const std::optional<Touch>& touch_at_end() const { return touch_at_end_; }

  [[nodiscard]] bool is_free(const JointVector& q);
  [[nodiscard]] bool is_free(const JointVector& from, const JointVector& to);
  /// Whether the whole curve is free.
  [[nodiscard]] bool is_free(const PostureCurve& curve);
  /// The first place on the curve that is not free.
  [[nodiscard]] std::optional<Touch> first_touch(const PostureCurve& curve);

  /// Longest lever of each joint over all shapes that it moves [m].
  [[nodiscard]] const JointVector& levers() const { return levers_; }
  /// Postures whose distances were measured.
  [[nodiscard]] std::size_t evaluations() const { return evaluations_; }

 private:
  struct Mover {
    ConvexShape shape;
    Eigen::Isometry3d X_LS = Eigen::Isometry3d::Identity();
    std::size_t link = 0;
    enum class Part : std::uint8_t { kLink, kTool, kHeld } part = Part::kLink;
    const std::string* name = nullptr;
    double radius = 0;
    JointVector levers;  ///< longest distance from each joint's axis [m]
    Eigen::Isometry3d X_BS = Eigen::Isometry3d::Identity();
  };
  struct SelfPair {
    std::size_t mover = 0, other = 0;
    JointVector levers;  ///< of the joints between them
    double clearance_m = 0;
  };
  /// A pair that is nearer than the clearance at an end of the move.
  struct NearPair {
    std::size_t obstacle = 0;
    double clearance_m = 0;  ///< that is left to it
    struct End {
      double depth_m = 0;  ///< 0 = it does not touch there
      Eigen::Vector3d p_B = Eigen::Vector3d::Zero();
    };
    std::array<End, 2> ends;
  };
  enum class Verdict { kFree, kUnproven, kTouches };

  void add_link_shapes();
  void add_carried();
  void add_self_pairs();
  [[nodiscard]] JointVector levers_of(const Mover& mover) const;
  void place(const JointVector& q);
  [[nodiscard]] Result<void> add_end(const JointVector& q, std::size_t end);
  [[nodiscard]] double depth_allowed(const Mover& mover, const Obstacle& obstacle) const;
  [[nodiscard]] double clearance_of(std::size_t mover, std::size_t obstacle, double way) const;
  void record_end(std::size_t end, std::size_t mover, const std::string& other, double distance_m);
  [[nodiscard]] bool touches(double u);
  [[nodiscard]] bool is_proven(double u, const JointVector& travel);
  [[nodiscard]] Verdict examine(double u, const JointVector& travel);
  [[nodiscard]] bool is_free_between(const PostureCurve& curve, double from, double to, bool first);
  void record(double u, std::size_t mover, const std::string& other, double distance_m);

  const ArmModel& model_;
  const Surroundings& around_;
  std::string base_name_;
  std::vector<Obstacle> obstacles_;  ///< in reach
  ObstacleTree tree_;
  std::vector<Mover> movers_;
  std::vector<SelfPair> self_pairs_;
  std::vector<std::vector<NearPair>> near_;  ///< by mover
  JointVector levers_;
  std::vector<Eigen::Isometry3d> X_BL_;
  std::optional<Touch> touch_, touch_at_end_;
  std::size_t evaluations_ = 0;
  std::size_t last_evaluation_ = 0;  ///< of the check that runs
};

}  // namespace aprsim::robot
