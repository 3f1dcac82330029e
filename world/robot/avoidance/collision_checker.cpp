#include "world/robot/avoidance/collision_checker.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "world/robot/kinematics/dynamics.hpp"
#include "world/robot/model/joint_rotation.hpp"

namespace aprsim::robot {
namespace {

/// A pair that must not touch may come so near less: a motion along the least distance can then be
/// proven free.
constexpr double kSlack_m = 3e-4;
/// Pieces of a motion in which nothing travels farther are not divided.
constexpr double kFinest_m = 2e-5;
/// A motion that needs more postures than this counts as blocked: none of a sane state does.
constexpr std::size_t kMostEvaluations = 60'000;
/// Larger pieces are divided without a check of their surroundings.
constexpr double kCoarsest_m = 0.4;
/// A pair that touches at an end moves apart by at least this share of its way.
constexpr double kWayOut = 0.7;
/// Links of one arm collide only if they are so many apart, as in the physics.
constexpr std::size_t kSelfDistance = 3;
/// Own links keep this distance from each other, or what they have at an end.
constexpr double kSelfClearance_m = 5e-3;
/// Overlaps at an end that are no error: of an arm at rest in contact; of a tool with a part or
/// with what holds it; of what is held with what carries it, where shapes have no pockets.
constexpr double kArmDepth_m = 2e-3, kToolDepth_m = 4e-3, kPartDepth_m = 25e-3;

/// The reach of the arm's shapes from its base, whatever the joints do.
double reach_of(const ArmModel& model, const Surroundings& around) {
  double reach = 0, farthest = 0;
  for (std::size_t link = 0; link < model.links.size(); ++link) {
    if (link > 0) reach += longest_offset(model.joints[link - 1]);
    if (link > 0 && link + 1 == model.links.size()) reach += flange_offset(model);
    for (const LinkShape& each : model.links[link].collision) {
      farthest = std::max(farthest, reach + each.X_LS.translation().norm() +
                                        convex_shape(each.shape).bounding_radius());
    }
  }
  for (const CarriedShape& each : around.carried) {
    farthest =
        std::max(farthest, reach + each.X_FS.translation().norm() + each.shape.bounding_radius());
  }
  return farthest;
}

std::vector<Obstacle> in_reach(const ArmModel& model, const Surroundings& around) {
  const double reach = reach_of(model, around) + around.clearance_m;
  std::vector<Obstacle> near;
  for (const Obstacle& each : around.obstacles) {
    const Eigen::AlignedBox3d box = each.shape.bounds(each.X_BS);
    if (box.squaredExteriorDistance(Eigen::Vector3d::Zero()) <= reach * reach) near.push_back(each);
  }
  return near;
}

std::vector<Eigen::AlignedBox3d> boxes_of(const std::vector<Obstacle>& obstacles) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const Obstacle& each : obstacles) boxes.push_back(each.shape.bounds(each.X_BS));
  return boxes;
}

}  // namespace

CollisionChecker::CollisionChecker(const ArmModel& model, const Surroundings& around)
    : model_(model),
      around_(around),
      base_name_(model.links.front().name),
      obstacles_(in_reach(model, around)),
      tree_(boxes_of(obstacles_)),
      X_BL_(model.links.size()) {
  add_carried();
  add_link_shapes();
  // The outer links come first: they move farthest and are the most likely to be unproven.
  std::ranges::stable_sort(movers_, std::greater(), &Mover::link);
  levers_ = JointVector::Zero(model.dof());
  for (Mover& mover : movers_) {
    mover.levers = levers_of(mover);
    levers_ = levers_.cwiseMax(mover.levers);
  }
  if (around.self_collision) add_self_pairs();
  near_.resize(movers_.size());
}

void CollisionChecker::add_link_shapes() {
  for (std::size_t link = 0; link < model_.links.size(); ++link) {
    for (const LinkShape& each : model_.links[link].collision) {
      const ConvexShape shape = convex_shape(each.shape);
      movers_.push_back({.shape = shape,
                         .X_LS = each.X_LS,
                         .link = link,
                         .name = &model_.links[link].name,
                         .radius = shape.bounding_radius()});
    }
  }
}

void CollisionChecker::add_carried() {
  for (const CarriedShape& each : around_.carried) {
    movers_.push_back({.shape = each.shape,
                       .X_LS = each.X_FS,
                       .link = model_.links.size() - 1,
                       .part = each.held ? Mover::Part::kHeld : Mover::Part::kTool,
                       .name = &around_.names[each.name],
                       .radius = each.shape.bounding_radius()});
  }
}

void CollisionChecker::add_self_pairs() {
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    for (std::size_t k = i + 1; k < movers_.size(); ++k) {
      const Mover& far = movers_[i];
      const Mover& near = movers_[k];
      if (far.link < near.link + kSelfDistance) continue;
      SelfPair pair{.mover = i, .other = k, .levers = far.levers};
      // Joints before both move them together.
      for (std::size_t j = 0; j < near.link; ++j) pair.levers(static_cast<Eigen::Index>(j)) = 0;
      self_pairs_.push_back(std::move(pair));
    }
  }
}

/// Longest distance of any of the shape's points from each joint's axis, whatever the other joints
/// do, and 1 of prismatic joints: from the axis to the next joint's origin, and on from origin to
/// origin.
JointVector CollisionChecker::levers_of(const Mover& mover) const {
  JointVector levers = JointVector::Zero(model_.dof());
  Eigen::Vector3d next = mover.X_LS.translation();
  if (model_.X_LF && mover.link == model_.joints.size()) next = *model_.X_LF * next;
  double beyond = mover.radius;  // from `next` to the farthest point
  for (std::size_t link = mover.link; link > 0; --link) {
    const Joint& joint = model_.joints[link - 1];
    levers(static_cast<Eigen::Index>(link - 1)) =
        joint.prismatic ? 1 : joint.axis.cross(next).norm() + beyond;
    beyond += next.norm();
    next = joint.X_PJ.translation();
    beyond += longest_offset(joint) - next.norm();
  }
  return levers;
}

void CollisionChecker::place(const JointVector& q) {
  ++evaluations_;
  link_poses(model_, q, X_BL_);
  for (Mover& mover : movers_) mover.X_BS = X_BL_[mover.link] * mover.X_LS;
}

// ---- the ends of a move

double CollisionChecker::depth_allowed(const Mover& mover, const Obstacle& obstacle) const {
  if (mover.part == Mover::Part::kHeld) return kPartDepth_m;
  if (mover.part == Mover::Part::kLink) return kArmDepth_m;
  return obstacle.kind == Obstacle::Kind::kPart ? kPartDepth_m : kToolDepth_m;
}

Result<void> CollisionChecker::set_ends(const JointVector& start, const JointVector& goal) {
  for (auto& pairs : near_) pairs.clear();
  for (SelfPair& pair : self_pairs_) pair.clearance_m = kSelfClearance_m;
  touch_at_end_.reset();
  if (auto ok = add_end(start, 0); !ok) return ok;
  return add_end(goal, 1);
}

Result<void> CollisionChecker::add_end(const JointVector& q, std::size_t end) {
  const char* const which = end == 0 ? "start" : "goal";
  place(q);
  Result<void> result;
  for (std::size_t i = 0; i < movers_.size() && result; ++i) {
    const Mover& mover = movers_[i];
    if (mover.link == 0) continue;
    const double far = around_.clearance_m + kSlack_m;
    tree_.near(mover.X_BS.translation(), mover.radius + far, [&](std::size_t o) {
      const Obstacle& obstacle = obstacles_[o];
      const double d = distance_bound(mover.shape, mover.X_BS, obstacle.shape, obstacle.X_BS, far);
      if (d >= around_.clearance_m) return true;
      if (d < -depth_allowed(mover, obstacle)) {
        result = fail(ErrorCode::kFailedPrecondition, which,
                      "the " + std::string(which) + " is blocked: " + *mover.name + " touches " +
                          around_.names[obstacle.name]);
        record_end(end, i, around_.names[obstacle.name], d);
        return false;
      }
      auto known = std::ranges::find(near_[i], o, &NearPair::obstacle);
      if (known == near_[i].end()) {
        near_[i].push_back({.obstacle = o, .clearance_m = around_.clearance_m});
        known = near_[i].end() - 1;
      }
      // A gripper that touches a part may slide along it.
      const bool slides =
          mover.part == Mover::Part::kTool && obstacle.kind == Obstacle::Kind::kPart;
      known->clearance_m = std::min(known->clearance_m, slides ? d : std::max(d, 0.0));
      if (d < 0 && !slides) known->ends[end] = {-d, mover.X_BS.translation()};
      return true;
    });
  }
  for (SelfPair& pair : self_pairs_) {
    if (!result) break;
    const Mover& a = movers_[pair.mover];
    const Mover& b = movers_[pair.other];
    const double d = distance_bound(a.shape, a.X_BS, b.shape, b.X_BS, kSelfClearance_m);
    // Shapes that always overlap are no collision; those that only do at the goal are one.
    if (end == 1 && d < -kArmDepth_m && d < pair.clearance_m - kArmDepth_m) {
      result = fail(ErrorCode::kFailedPrecondition, which,
                    "the goal is blocked: " + *a.name + " touches its own " + *b.name);
      record_end(end, pair.mover, *b.name, d);
    }
    pair.clearance_m = std::min(pair.clearance_m, d);
  }
  return result;
}

/// The most that the pair has to keep at any posture to which the mover's centre travels by `way`.
double CollisionChecker::clearance_of(std::size_t mover, std::size_t obstacle, double way) const {
  double clearance = around_.clearance_m;
  for (const NearPair& pair : near_[mover]) {
    if (pair.obstacle != obstacle) continue;
    clearance = pair.clearance_m;
    for (const NearPair::End& end : pair.ends) {
      if (end.depth_m == 0) continue;
      const double off = (movers_[mover].X_BS.translation() - end.p_B).norm();
      clearance = std::min(clearance, kWayOut * (off + way) - end.depth_m);
    }
  }
  return clearance - kSlack_m;
}

void CollisionChecker::record_end(std::size_t end, std::size_t mover, const std::string& other,
                                  double distance_m) {
  touch_at_end_ = {*movers_[mover].name, other, distance_m, static_cast<double>(end),
                   movers_[mover].X_BS.translation()};
}

// ---- postures and motions

void CollisionChecker::record(double u, std::size_t mover, const std::string& other,
                              double distance_m) {
  touch_ = {*movers_[mover].name, other, distance_m, u, movers_[mover].X_BS.translation()};
}

/// Whether anything is too near at the present posture.
bool CollisionChecker::touches(double u) {
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    const Mover& mover = movers_[i];
    if (mover.link == 0) continue;
    const double far = around_.clearance_m;
    const bool clear = tree_.near(mover.X_BS.translation(), mover.radius + far, [&](std::size_t o) {
      const Obstacle& obstacle = obstacles_[o];
      const double d = distance_bound(mover.shape, mover.X_BS, obstacle.shape, obstacle.X_BS, far);
      if (d >= clearance_of(i, o, 0)) return true;
      record(u, i, around_.names[obstacle.name], d);
      return false;
    });
    if (!clear) return true;
  }
  for (const SelfPair& pair : self_pairs_) {
    const Mover& a = movers_[pair.mover];
    const Mover& b = movers_[pair.other];
    const double apart = (a.X_BS.translation() - b.X_BS.translation()).norm();
    if (apart - a.radius - b.radius > pair.clearance_m) continue;
    const double d = distance_bound(a.shape, a.X_BS, b.shape, b.X_BS, kSelfClearance_m);
    if (d >= pair.clearance_m - kSlack_m) continue;
    record(u, pair.mover, *b.name, d);
    return true;
  }
  return false;
}

/// Whether the postures that the joints reach from the present one within `travel` are free.
CollisionChecker::Verdict CollisionChecker::examine(double u, const JointVector& travel) {
  if (levers_.dot(travel) <= kCoarsest_m && is_proven(u, travel)) return Verdict::kFree;
  return touches(u) ? Verdict::kTouches : Verdict::kUnproven;
}

bool CollisionChecker::is_proven(double u, const JointVector& travel) {
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    const Mover& mover = movers_[i];
    if (mover.link == 0) continue;
    const double way = mover.levers.dot(travel);
    const double far = around_.clearance_m + way;
    const bool proven =
        tree_.near(mover.X_BS.translation(), mover.radius + far, [&](std::size_t o) {
          const Obstacle& obstacle = obstacles_[o];
          const double d =
              distance_bound(mover.shape, mover.X_BS, obstacle.shape, obstacle.X_BS, far);
          if (d - way >= clearance_of(i, o, way)) return true;
          record(u, i, around_.names[obstacle.name], d);
          return false;
        });
    if (!proven) return false;
  }
  for (const SelfPair& pair : self_pairs_) {
    const Mover& a = movers_[pair.mover];
    const Mover& b = movers_[pair.other];
    const double needed = pair.clearance_m - kSlack_m + pair.levers.dot(travel);
    const double apart = (a.X_BS.translation() - b.X_BS.translation()).norm();
    if (apart - a.radius - b.radius >= needed) continue;
    const double d = distance_bound(a.shape, a.X_BS, b.shape, b.X_BS, needed);
    if (d >= needed) continue;
    record(u, pair.mover, *b.name, d);
    return false;
  }
  return true;
}

bool CollisionChecker::is_free_between(const PostureCurve& curve, double from, double to,
                                       bool first) {
  const double middle = 0.5 * (from + to);
  place(curve.at(middle));
  const JointVector before = curve.travel(middle) - curve.travel(from);
  const JointVector after = curve.travel(to) - curve.travel(middle);
  const JointVector travel = before.cwiseMax(after);
  const Verdict verdict = examine(middle, travel);
  if (verdict == Verdict::kFree) return true;
  // Too small to divide: what is so near counts as a touch.
  if (evaluations_ > last_evaluation_) return false;
  if (levers_.dot(travel) < kFinest_m || (verdict == Verdict::kTouches && !first)) return false;
  const std::optional<Touch> here = touch_;
  if (!is_free_between(curve, from, middle, first)) return false;
  if (verdict == Verdict::kTouches) {
    touch_ = here;
    return false;
  }
  return is_free_between(curve, middle, to, first);
}

bool CollisionChecker::is_free(const JointVector& q) {
  place(q);
  return !touches(0);
}

bool CollisionChecker::is_free(const JointVector& from, const JointVector& to) {
  return is_free(PostureCurve({from, to}));
}

bool CollisionChecker::is_free(const PostureCurve& curve) {
  if (curve.length() == 0) return is_free(curve.postures().front());
  last_evaluation_ = evaluations_ + kMostEvaluations;
  return is_free_between(curve, 0, curve.length(), false);
}

std::optional<Touch> CollisionChecker::first_touch(const PostureCurve& curve) {
  touch_.reset();
  if (curve.length() == 0) {
    if (is_free(curve.postures().front())) return std::nullopt;
    return touch_;
  }
  last_evaluation_ = evaluations_ + kMostEvaluations;
  if (is_free_between(curve, 0, curve.length(), true)) return std::nullopt;
  // Without one it was given up.
  return touch_.value_or(Touch{model_.name, "something"});
}

}  // namespace aprsim::robot
