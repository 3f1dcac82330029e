#include "world/physics/contacts/arm_penalty.hpp"

#include <algorithm>

#include "world/physics/collision/pairs/piece_contacts.hpp"
#include "world/physics/contacts/part_collider.hpp"
#include "world/robot/servo/contact_law.hpp"

namespace aprsim::physics {
namespace {

// The real mobility of a contact point depends on the arm's pose, which is not known here; this is
// that of the lightest direction of either arm (0.6 kg at the tool), so the law is never too stiff.
constexpr double kMobility = 1 / 0.6;  // [1/kg]

/// Force on the body that the normal points into and that moves with `v_W` relative to the other.
Eigen::Vector3d contact_force(const Contact& point, const Eigen::Vector3d& v_W,
                              const PhysicsModel& model, std::size_t points) {
  // Kelvin-Voigt model: spring and damper along the normal, regularised Coulomb friction across it.
  // The spring is shared by the pair's contact points.
  robot::ContactLaw law;
  law.friction = model.scene.physics.friction.robot;
  const int count = static_cast<int>(points);
  const double speed = v_W.dot(point.n_W);
  const double normal =
      robot::normal_force(law, point.depth_m, -speed, kMobility, model.step_s, count);
  return normal * point.n_W + robot::friction_force(law, normal, v_W - speed * point.n_W, kMobility,
                                                    model.step_s, count);
}

int shape_count(const ArmLinks& arm) { return static_cast<int>(arm.shapes().size()); }

}  // namespace

ArmPenalty::ArmPenalty(PhysicsModel& model) : model_(model) {
  found_.reserve(kMaxGeomPoints);
  // Geoms of the fixed boxes, which have none otherwise.
  for (const auto& shape : model.fixed.shapes) {
    fixed_geoms_.push_back(OdeGeom::box(shape.size));
    fixed_geoms_.back().set_pose(shape.X_WS);
  }
  // Neighbouring links overlap by construction of the model; a penalty between them would be a
  // constant force. Pairs of shapes that overlap at the start are left out.
  const int robots = static_cast<int>(model.arms.size());
  for (int r = 0; r < robots; ++r) {
    const int shapes = shape_count(model.arms[static_cast<std::size_t>(r)]);
    auto& on_fixed = on_fixed_.emplace_back();
    for (int s = 0; s < shapes; ++s) {
      for (std::size_t f = 0; f < fixed_geoms_.size(); ++f) {
        found_.clear();
        on_fixed_shape(shape(r, s), f);
        if (found_.empty()) on_fixed.shapes.push_back({s, f});
      }
    }
    for (int q = r; q < robots; ++q) {
      auto& arms = pairs_.emplace_back(ArmPair{r, q});
      for (int s = 0; s < shapes; ++s) {
        for (int t = 0; t < shape_count(model.arms[static_cast<std::size_t>(q)]); ++t) {
          if (may_meet(r, s, q, t) && !overlap(shape(r, s).geom, shape(q, t).geom)) {
            arms.shapes.push_back({s, t});
          }
        }
      }
    }
  }
}

bool ArmPenalty::overlap(const OdeGeom& a, const OdeGeom& b) {
  found_.clear();
  collide_geoms(a, b, kGround, kGround, SurfacePair::kRobotAny, found_);
  return !found_.empty();
}

const ArmShape& ArmPenalty::shape(int robot, int index) const {
  return model_.arms[static_cast<std::size_t>(robot)].shapes()[static_cast<std::size_t>(index)];
}

/// Links of one arm only where it checks itself and they are some links apart.
bool ArmPenalty::may_meet(int robot_a, int shape_a, int robot_b, int shape_b) const {
  if (robot_a != robot_b) return true;
  if (!model_.scene.robots[static_cast<std::size_t>(robot_a)].self_collision) return false;
  // Joint limits keep near links apart; only distant ones can meet.
  return shape(robot_b, shape_b).link - shape(robot_a, shape_a).link >= kSelfCollisionDistance;
}

void ArmPenalty::find(std::vector<std::vector<ArmForce>>& forces) {
  const int robots = static_cast<int>(model_.arms.size());
  auto pair = pairs_.begin();
  for (int r = 0; r < robots; ++r) {
    on_fixed(r, forces);
    for (int q = r; q < robots; ++q) on_other(*pair++, forces);
  }
}

/// Geoms are of boxes; pieces of fixtures are collided without ODE.
void ArmPenalty::on_fixed_shape(const ArmShape& link, std::size_t f) {
  const StaticShape& fixed = model_.fixed.shapes[f];
  const ContactSides sides{kGround, kGround, SurfacePair::kRobotAny};
  if (!fixed.piece) {
    collide_geoms(link.geom, fixed_geoms_[f], kGround, kGround, sides.pair, found_);
    return;
  }
  detail::GearShape round;
  shape_on_shape(shape_of_link(link, round), link.X_WS, fixed.shape(), fixed.X_WS, sides, found_);
}

/// Contact points in a pair's order: shapes of the arm, then fixed things.
void ArmPenalty::on_fixed(int robot, std::vector<std::vector<ArmForce>>& forces) {
  const auto r = static_cast<std::size_t>(robot);
  const auto& arm = model_.arms[r];
  ArmOnFixed& known = on_fixed_[r];
  if (known.apart == arm.placement()) return;
  known.apart = arm.placement();
  for (const auto& [s, f] : known.shapes) {
    const auto& link = shape(robot, s);
    if (!link.bounds.meets(model_.fixed.shapes[f].bounds)) continue;
    found_.clear();
    on_fixed_shape(link, f);
    if (!found_.empty()) known.apart = 0;
    for (const auto& point : found_) {
      // The arm's motion of the last step: the force acts on the joints in the next one.
      const Eigen::Vector3d v = arm.last_velocity(link.link, point.p_W, model_.step_s);
      const Eigen::Vector3d force = contact_force(point, v, model_, found_.size());
      forces[r].push_back(
          {.link = link.link,
           .p_W = point.p_W,
           .f_W = force,
           .partner = {api::ContactSide::Kind::kFixed, model_.fixed.shapes[f].first},
           .penalty = true});
    }
  }
}

/// Equal and opposite forces on both; of one arm with itself too.
void ArmPenalty::on_other(ArmPair& arms, std::vector<std::vector<ArmForce>>& forces) {
  const int robot_a = arms.a, robot_b = arms.b;
  const auto a = static_cast<std::size_t>(robot_a), b = static_cast<std::size_t>(robot_b);
  const auto& arm_a = model_.arms[a];
  const auto& arm_b = model_.arms[b];
  if (arms.apart_a == arm_a.placement() && arms.apart_b == arm_b.placement()) return;
  arms.apart_a = arm_a.placement();
  arms.apart_b = arm_b.placement();
  // Two robots face each other across the belt and rarely come within each other's bounds.
  if (robot_a != robot_b && !arm_a.bounds().meets(arm_b.bounds())) return;
  for (const auto& [s, t] : arms.shapes) {
    const auto& one = shape(robot_a, s);
    const auto& other = shape(robot_b, t);
    if (!one.bounds.meets(other.bounds)) continue;
    found_.clear();
    collide_geoms(one.geom, other.geom, kGround, kGround, SurfacePair::kRobotAny, found_);
    if (!found_.empty()) arms.apart_a = 0;
    for (const auto& point : found_) {
      const Eigen::Vector3d v = arm_a.last_velocity(one.link, point.p_W, model_.step_s) -
                                arm_b.last_velocity(other.link, point.p_W, model_.step_s);
      const Eigen::Vector3d force = contact_force(point, v, model_, found_.size());
      using enum api::ContactSide::Kind;
      constexpr int first = api::ContactSide::kFirstLink;
      forces[a].push_back({one.link,
                           point.p_W,
                           force,
                           {kRobot, robot_b, first + other.link},
                           other.link,
                           false,
                           true});
      forces[b].push_back({other.link,
                           point.p_W,
                           -force,
                           {kRobot, robot_a, first + one.link},
                           one.link,
                           false,
                           true});
    }
  }
}

}  // namespace aprsim::physics
