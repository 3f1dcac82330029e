#include "world/physics/physics_model.hpp"

namespace aprsim::physics {
namespace {

constexpr double kWorldErp = 0.2;
constexpr double kWorldCfm = 1e-9;
constexpr double kMaxCorrectingVelocity = 0.5;  // [m/s]
constexpr unsigned kSolverMemory = 4u << 20;    // [bytes], so that no step has to allocate

ode::World make_world(const scene::Scene& scene) {
  ode::prepare_thread();
  ode::World world(dWorldCreate());
  dWorldSetGravity(world.get(), 0, 0, -scene.physics.gravity_m_s2);
  dWorldSetERP(world.get(), kWorldErp);
  dWorldSetCFM(world.get(), kWorldCfm);
  dWorldSetContactMaxCorrectingVel(world.get(), kMaxCorrectingVelocity);
  dWorldSetAutoDisableFlag(world.get(), 0);
  const dWorldStepReserveInfo reserve = {sizeof(dWorldStepReserveInfo), 1.5f, kSolverMemory};
  dWorldSetStepMemoryReservationPolicy(world.get(), &reserve);
  return world;
}

}  // namespace

PhysicsModel::PhysicsModel(const scene::Scene& the_scene, std::span<const robot::ArmModel> models,
                           std::span<const std::vector<Eigen::Isometry3d>> X_WL)
    : scene(the_scene),
      step_s(the_scene.physics.step_s),
      world(make_world(the_scene)),
      nodes(static_cast<int>(the_scene.trays.size() + the_scene.gears.size()),
            static_cast<int>(the_scene.robots.size())),
      bodies(make_free_bodies(the_scene, world.get())),
      fixed(make_fixed_shapes(the_scene)),
      simplification(the_scene.physics, bodies, fixed, world.get()) {
  for (std::size_t r = 0; r < the_scene.robots.size(); ++r) {
    grippers.emplace_back(the_scene.robots[r], world.get(), X_WL[r].back(), step_s);
    arms.emplace_back(models[r], world.get(), X_WL[r]);
  }
  touches.reserve(kTouchCapacity);
}

dBodyID PhysicsModel::ode_body(BodyIndex node) const {
  if (node < 0) return nullptr;
  if (nodes.is_free(node)) return body(simplification.root(node)).body.get();
  const auto robot = static_cast<std::size_t>(nodes.robot_of(node));
  if (nodes.is_link(node)) return arms[robot].body(nodes.link_of(node));
  return grippers[robot].bodies()[static_cast<std::size_t>(nodes.part_of(node))];
}

std::string_view PhysicsModel::name_of(BodyIndex node, int fixed_shape) const {
  if (node < 0) {
    if (fixed_shape < 0) return {};
    return fixed.shapes[static_cast<std::size_t>(fixed_shape)].name;
  }
  if (nodes.is_free(node)) return body(node).name;
  return scene.robots[static_cast<std::size_t>(nodes.robot_of(node))].name;
}

}  // namespace aprsim::physics
