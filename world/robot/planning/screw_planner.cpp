#include "world/robot/planning/screw_planner.hpp"

#include <algorithm>
#include <cmath>

#include "world/robot/trajectory/limits/segment_limits.hpp"

namespace aprsim::robot {
namespace {

constexpr std::size_t kMaxStarts = 24;  ///< start postures to try

}  // namespace

Result<void> ScrewPlanner::plan(const api::MoveScrew& screw, MotionPlan& out) const {
  out.clear();
  if (!screw.start) return add_screw(screw, start_.q, out);
  const Eigen::Isometry3d X_BT = planner_.pose_in_base(screw.start->X_RT);
  const auto nearest = planner_.target_posture(X_BT * start_.X_FT.inverse(), start_.q);
  if (!nearest) return tl::unexpected(nearest.error());
  const ToolLimits tool = limits_.effective(screw.start->limits);
  // The whole motion from one start posture.
  const auto from = [&](const JointVector& posture) -> Result<void> {
    out.clear();
    planner_.add_joint_motion(posture, start_, tool, limits_.maximum(), out);
    return add_screw(screw, posture, out);
  };
  const Result<void> first = from(*nearest);
  if (first) return first;
  // Another posture may have enough of its last joint's range left for the turn.
  for (const JointVector& posture : start_postures(X_BT)) {
    if (from(posture)) return {};
  }
  return first;
}

/// Postures for the start pose, the nearest first; of a redundant arm those with the present elbow
/// angle and with the one that suits the pose best.
std::vector<JointVector> ScrewPlanner::start_postures(const Eigen::Isometry3d& X_BT) const {
  const InverseKinematics& ik = planner_.arm().ik;
  const Eigen::Isometry3d X_BF = X_BT * start_.X_FT.inverse();
  std::vector<IkSolution> all = ik.all(X_BF, ik.elbow_of(start_.q));
  // The branch at the start decides how much of the last joint's range is left for turning, so that
  // all are candidates.
  if (const auto elbow = ik.choose_elbow(X_BF, start_.q); elbow && start_.q.size() > 6) {
    for (const IkSolution& more : ik.all(X_BF, *elbow)) all.push_back(more);
  }
  std::stable_sort(all.begin(), all.end(), [&](const IkSolution& a, const IkSolution& b) {
    return planner_.range_distance(a.q, start_.q) < planner_.range_distance(b.q, start_.q);
  });
  std::vector<JointVector> postures;
  for (std::size_t i = 0; i < std::min(all.size(), kMaxStarts); ++i) postures.push_back(all[i].q);
  return postures;
}

/// The free advance along the axis, then the helix.
Result<void> ScrewPlanner::add_screw(const api::MoveScrew& screw, const JointVector& start,
                                     MotionPlan& out) const {
  const ToolLimits tool = limits_.effective({});
  JointVector q = start;
  Eigen::Isometry3d X_BT = planner_.tool_pose(q, start_.X_FT);
  const Eigen::Vector3d axis = X_BT.linear().col(2);
  if (screw.free_m != 0) {
    // CRCL MoveScrew: a free advance along the axis, then advance and turn together.
    X_BT.translation() += screw.free_m * axis;
    auto ok = planner_.add_line(X_BT, {q, start_.X_FT}, tool, limits_.maximum(), out);
    if (!ok) {
      ok.error().message = "free advance of the screw: " + ok.error().message;
      return ok;
    }
    q = out.end();
  }
  if (screw.screw_m == 0 && screw.turn_rad == 0) {
    // A sequence has at least one motion.
    if (out.empty()) {
      planner_.add_joint_motion(q, {q, start_.X_FT}, tool, limits_.maximum(), out);
    }
    return {};
  }
  // The helix about the tool's axis, or one parallel to it.
  ToolHelix helix{.X_BT_start = X_BT,
                  .point_B = X_BT.translation(),
                  .direction_B = axis,
                  .travel_m = screw.screw_m,
                  .turn_rad = screw.turn_rad};
  if (screw.axis_point_R) helix.point_B = planner_.X_BR() * *screw.axis_point_R;
  PathMotion& path = out.add().as_path();
  SegmentLimits segment;
  const double duration =
      segment.add(helix.length_m(), std::abs(helix.turn_rad), tool, limits_.maximum());
  path.begin_tool_path(start_.X_FT).make_helix(helix, duration);
  return planner_.plan_path(segment.move(q, planner_.joint_limits()), path);
}

}  // namespace aprsim::robot
