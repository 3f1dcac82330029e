#include "world/physics/bodies/arm_links.hpp"

#include <algorithm>
#include <array>
#include <variant>

namespace aprsim::physics {
namespace {

/// ODE geom and half extents of a primitive of the arm's description.
struct MakeShape {
  ArmShape& shape;
  void operator()(const robot::BoxShape& box) const {
    shape.geom.reset(dCreateBox(nullptr, box.size.x(), box.size.y(), box.size.z()));
    shape.half = 0.5 * box.size;
  }
  void operator()(const robot::CapsuleShape& capsule) const {
    shape.geom.reset(dCreateCapsule(nullptr, capsule.radius_m, capsule.length_m));
    shape.half = {capsule.radius_m, capsule.radius_m, 0.5 * capsule.length_m + capsule.radius_m};
  }
  void operator()(const robot::CylinderShape& cylinder) const {
    shape.geom.reset(dCreateCylinder(nullptr, cylinder.radius_m, cylinder.length_m));
    shape.half = {cylinder.radius_m, cylinder.radius_m, 0.5 * cylinder.length_m};
  }
  void operator()(const robot::SphereShape& sphere) const {
    shape.geom.reset(dCreateSphere(nullptr, sphere.radius_m));
    shape.half = Eigen::Vector3d::Constant(sphere.radius_m);
  }
};

}  // namespace

ArmLinks::ArmLinks(const robot::ArmModel& model, dWorldID world,
                   std::span<const Eigen::Isometry3d> X_WL)
    : X_WL_before_(X_WL.begin(), X_WL.end()), X_WL_(X_WL_before_), X_WL_next_(X_WL_) {
  for (std::size_t link = 0; link < X_WL_.size(); ++link) {
    auto& body = bodies_.emplace_back(dBodyCreate(world));
    dBodySetKinematic(body.get());
    dBodyDisable(body.get());
    if (link == 0) continue;  // the base stands on its pedestal, inside fixed things
    for (const auto& collision : model.links[link].collision) {
      ArmShape shape;
      shape.link = static_cast<int>(link);
      shape.X_LS = collision.X_LS;
      std::visit(MakeShape{shape}, collision.shape);
      shapes_.push_back(std::move(shape));
    }
  }
  update_shapes();
}

void ArmLinks::set_next(std::span<const Eigen::Isometry3d> X_WL_next) {
  std::copy(X_WL_next.begin(), X_WL_next.end(), X_WL_next_.begin());
}

void ArmLinks::end_step() {
  bool moved = false;
  for (std::size_t i = 0; i < X_WL_.size(); ++i) {
    X_WL_before_[i] = X_WL_[i];
    // An arm that stands still costs no new bounds.
    if (X_WL_[i].matrix() == X_WL_next_[i].matrix()) continue;
    X_WL_[i] = X_WL_next_[i];
    moved = true;
  }
  if (moved) update_shapes();
}

void ArmLinks::restore(const State& state) {
  X_WL_before_ = state.X_WL_before;
  X_WL_ = state.X_WL;
  X_WL_next_ = state.X_WL_next;
  update_shapes();
}

/// Geoms and bounds at the poses of now.
void ArmLinks::update_shapes() {
  bool first = true;
  for (auto& shape : shapes_) {
    const Eigen::Isometry3d X_WS = X_WL(shape.link) * shape.X_LS;
    set_geom_pose(shape.geom.get(), X_WS);
    shape.bounds = aabb_of_box(2 * shape.half, X_WS);
    bounds_ = first ? shape.bounds : bounds_.joined(shape.bounds);
    first = false;
  }
}

Eigen::Vector3d ArmLinks::last_velocity(int link, const Eigen::Vector3d& p_W, double step_s) const {
  // The material point that is at p_W now, one step ago.
  const auto& before = X_WL_before_[static_cast<std::size_t>(link)];
  return (p_W - before * (X_WL(link).inverse() * p_W)) / step_s;
}

void ArmLinks::place_link(int link, double step_s) {
  const Eigen::Isometry3d& X = X_WL(link);
  const Eigen::Isometry3d& X_next = X_WL_next(link);
  // The screw from the one pose to the other, spread evenly over the step.
  const Eigen::AngleAxisd turn(X_next.linear() * X.linear().transpose());
  ode::set_rotation(body(link), X.linear());
  ode::set_position(body(link), X.translation());
  ode::set_velocity(body(link), (X_next.translation() - X.translation()) / step_s,
                    turn.angle() / step_s * turn.axis());
}

void set_geom_pose(dGeomID geom, const Eigen::Isometry3d& X_W) {
  const Eigen::Matrix3d& R = X_W.linear();
  // Rows padded to four, as ODE has them.
  const dMatrix3 rotation = {R(0, 0), R(0, 1), R(0, 2), 0,       R(1, 0), R(1, 1),
                             R(1, 2), 0,       R(2, 0), R(2, 1), R(2, 2), 0};
  dGeomSetRotation(geom, rotation);
  dGeomSetPosition(geom, X_W.translation().x(), X_W.translation().y(), X_W.translation().z());
}

void collide_geoms(dGeomID geom_a, dGeomID geom_b, BodyIndex a, BodyIndex b, SurfacePair pair,
                   std::vector<Contact>& out) {
  std::array<dContactGeom, kMaxPoints> points;
  const int count = dCollide(geom_a, geom_b, kMaxPoints, points.data(), sizeof(dContactGeom));
  for (int i = 0; i < count; ++i) {
    const auto& point = points[static_cast<std::size_t>(i)];
    out.push_back({a, b, ode::vector(point.pos), ode::vector(point.normal), point.depth, pair});
  }
}

}  // namespace aprsim::physics
