#include "world/physics/model/physics_model.hpp"

#include <algorithm>
#include <limits>

#include "world/physics/model/tool_changes.hpp"

namespace aprsim::physics {
namespace {

constexpr double kFall = 2;  // [m] below the lowest thing until a body is lost

/// Below all that stands, lies or reaches there.
double lost_below(const PhysicsModel& model) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& shape : model.fixed.shapes) lowest = std::min(lowest, shape.bounds.min.z());
  for (const auto& body : model.bodies) {
    if (!body.mounted) lowest = std::min(lowest, body.bounds.min.z());
  }
  for (const auto& arm : model.arms) lowest = std::min(lowest, arm.X_WL(0).translation().z());
  return lowest - kFall;
}

}  // namespace

PhysicsModel::PhysicsModel(const scene::Scene& the_scene,
                           std::span<const robot::ArmModel> arm_models,
                           std::span<const std::vector<Eigen::Isometry3d>> X_WL)
    : scene(the_scene),
      step_s(the_scene.physics.step_s),
      tools(scene::tools_of(the_scene)),
      ids(static_cast<int>(the_scene.trays.size() + the_scene.gears.size() +
                           the_scene.parts.size()),
          static_cast<int>(tools.size())),
      materials(the_scene),
      bodies(make_free_bodies(the_scene, tools)),
      fixed(make_fixed_shapes(the_scene)),
      simplification(the_scene.physics, bodies, fixed) {
  for (std::size_t r = 0; r < the_scene.robots.size(); ++r) {
    grippers.emplace_back(the_scene.robots[r].gripper, the_scene.physics, X_WL[r].back());
    arms.emplace_back(arm_models[r], X_WL[r]);
  }
  for (const scene::Tool& tool : tools) {
    parked.emplace_back(tool.gripper, the_scene.physics,
                        tool.X_WQ.isometry() * tool.X_QT.isometry());
  }
  tool_of_robot.assign(the_scene.robots.size(), -1);
  // Every tool is created as a free body first. Mounting it takes the same path as a tool change at
  // run time.
  const std::vector<int> start = scene::tools_at_start(the_scene);
  for (std::size_t r = 0; r < start.size(); ++r) {
    if (start[r] >= 0) attach_tool(*this, static_cast<int>(r), start[r], X_WL[r].back());
  }
  constraints.reserve(kConstraintCapacity);
  lost_below_m = lost_below(*this);
}

void PhysicsModel::set_step_s(double s) {
  step_s = s;
  simplification.set_step_s(s);
  for (auto* mechanisms : {&grippers, &parked}) {
    for (GripperMechanism& mechanism : *mechanisms) mechanism.set_step_s(s);
  }
}

bool PhysicsModel::is_held(int body) const {
  return std::ranges::any_of(grippers, [body](const GripperMechanism& gripper) {
    return gripper.state().held_body == body;
  });
}

double PhysicsModel::displacement_m(int number) const {
  const FreeBody& free = body(number);
  return step_s * (free.v_com_W.norm() + free.radius_m * free.omega_W.norm());
}

const GripperMechanism& PhysicsModel::mechanism(int tool) const {
  for (std::size_t r = 0; r < tool_of_robot.size(); ++r) {
    if (tool_of_robot[r] == tool) return grippers[r];
  }
  return parked[static_cast<std::size_t>(tool)];
}

void PhysicsModel::open_tools() {
  for (int t = 0; t < static_cast<int>(tools.size()); ++t) {
    body(ids.tool(t)).tool->set_opening(mechanism(t).state().separation_m);
  }
}

RigidBody* PhysicsModel::rigid_body(BodyIndex id) {
  if (id < 0) return nullptr;
  // Contacts of a merged body act on the rigid body of its root.
  if (ids.is_free(id)) return &body(simplification.root(id)).body;
  const auto robot = static_cast<std::size_t>(ids.robot_of(id));
  if (ids.is_link(id)) return &arms[robot].body(ids.link_of(id));
  return &grippers[robot].body_of(ids.part_of(id));
}

}  // namespace aprsim::physics
