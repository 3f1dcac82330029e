#include "world/physics/bodies/arm_links.hpp"

#include <algorithm>
#include <utility>
#include <variant>

namespace aprsim::physics {
namespace {

/// Half extents and geom of a primitive of the arm's description.
struct Primitive {
  Eigen::Vector3d half;
  OdeGeom geom;
};

struct MakePrimitive {
  Primitive operator()(const robot::BoxShape& box) const {
    return {0.5 * box.size, OdeGeom::box(box.size)};
  }
  Primitive operator()(const robot::CapsuleShape& capsule) const {
    const double radius = capsule.radius_m, length = capsule.length_m;
    return {{radius, radius, 0.5 * length + radius}, OdeGeom::capsule(radius, length)};
  }
  Primitive operator()(const robot::CylinderShape& cylinder) const {
    const double radius = cylinder.radius_m, length = cylinder.length_m;
    return {{radius, radius, 0.5 * length}, OdeGeom::cylinder(radius, length)};
  }
  Primitive operator()(const robot::SphereShape& sphere) const {
    return {Eigen::Vector3d::Constant(sphere.radius_m), OdeGeom::sphere(sphere.radius_m)};
  }
};

}  // namespace

ArmLinks::ArmLinks(const robot::ArmModel& model, std::span<const Eigen::Isometry3d> X_WL)
    : X_WL_before_(X_WL.begin(), X_WL.end()),
      X_WL_(X_WL_before_),
      X_WL_next_(X_WL_),
      bodies_(X_WL.size()) {
  // Primitives collide by ODE's dCollide; half extents bound them for the broad phase.
  // The base stands on its pedestal, inside fixed things.
  for (std::size_t link = 1; link < X_WL_.size(); ++link) {
    for (const auto& collision : model.links[link].collision) {
      Primitive primitive = std::visit(MakePrimitive{}, collision.shape);
      shapes_.push_back({.link = static_cast<int>(link),
                         .X_LS = collision.X_LS,
                         .half = primitive.half,
                         .shape = collision.shape,
                         .geom = std::move(primitive.geom),
                         .bounds = {}});
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
    // An arm at rest keeps its bounds.
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
  ++placement_;
  bool first = true;
  for (auto& shape : shapes_) {
    shape.X_WS = X_WL(shape.link) * shape.X_LS;
    shape.geom.set_pose(shape.X_WS);
    shape.bounds = aabb_of_box(2 * shape.half, shape.X_WS);
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
  // Contacts see the link at the start of the step with its mean velocity over the step, as they
  // see free bodies.
  const Eigen::Isometry3d& X = X_WL(link);
  const Eigen::Isometry3d& X_next = X_WL_next(link);
  // The screw from the one pose to the other, spread evenly over the step.
  const Eigen::AngleAxisd turn(X_next.linear() * X.linear().transpose());
  RigidBody& moved = body(link);
  moved.set_orientation(Eigen::Matrix3d(X.linear()));
  moved.set_position(X.translation());
  moved.set_velocity((X_next.translation() - X.translation()) / step_s,
                     turn.angle() / step_s * turn.axis());
}

}  // namespace aprsim::physics
