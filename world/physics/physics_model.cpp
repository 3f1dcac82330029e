#include "world/physics/physics_model.hpp"

#include <algorithm>
#include <limits>

namespace aprsim::physics {
namespace {

constexpr double kFall = 2;  // [m] below the lowest thing until a body is lost

ode::World make_world(const scene::Scene& scene) {
  ode::prepare_thread();
  ode::World world(dWorldCreate());
  dWorldSetGravity(world.get(), 0, 0, -scene.physics.gravity_m_s2);
  dWorldSetAutoDisableFlag(world.get(), 0);
  return world;
}

/// Below all that stands, lies or reaches there.
double lost_below(const PhysicsModel& model) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& shape : model.fixed.shapes) lowest = std::min(lowest, shape.bounds.min.z());
  for (const auto& body : model.bodies) lowest = std::min(lowest, body.bounds.min.z());
  for (const auto& arm : model.arms) lowest = std::min(lowest, arm.X_WL(0).translation().z());
  return lowest - kFall;
}

}  // namespace

PhysicsModel::PhysicsModel(const scene::Scene& the_scene,
                           std::span<const robot::ArmModel> arm_models,
                           std::span<const std::vector<Eigen::Isometry3d>> X_WL)
    : scene(the_scene),
      step_s(the_scene.physics.step_s),
      world(make_world(the_scene)),
      ids(static_cast<int>(the_scene.trays.size() + the_scene.gears.size())),
      bodies(make_free_bodies(the_scene, world.get())),
      fixed(make_fixed_shapes(the_scene)),
      simplification(the_scene.physics, bodies, fixed) {
  for (std::size_t r = 0; r < the_scene.robots.size(); ++r) {
    grippers.emplace_back(the_scene.robots[r], world.get(), X_WL[r].back(), step_s);
    arms.emplace_back(arm_models[r], world.get(), X_WL[r]);
  }
  constraints.reserve(kConstraintCapacity);
  lost_below_m = lost_below(*this);
}

dBodyID PhysicsModel::ode_body(BodyIndex id) const {
  if (id < 0) return nullptr;
  if (ids.is_free(id)) return body(simplification.root(id)).body.get();
  const auto robot = static_cast<std::size_t>(ids.robot_of(id));
  if (ids.is_link(id)) return arms[robot].body(ids.link_of(id));
  return grippers[robot].bodies()[static_cast<std::size_t>(ids.part_of(id))];
}

}  // namespace aprsim::physics
