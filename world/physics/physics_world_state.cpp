#include <stdexcept>
#include <string>

#include "world/physics/physics_world_impl.hpp"

namespace aprsim::physics {
namespace {

/// Where the names of an arm's contacts live in this cell; empty when there is no such name.
std::string_view name_in(const PhysicsModel& cell, const std::string& name) {
  for (const auto& body : cell.bodies) {
    if (body.name == name) return body.name;
  }
  for (const auto& shape : cell.fixed.shapes) {
    if (shape.name == name) return shape.name;
  }
  for (const auto& robot : cell.scene.robots) {
    if (robot.name == name) return robot.name;
  }
  return {};
}

}  // namespace

struct PhysicsWorld::State::Data {
  struct Body {
    ode::SavedState ode;
    Eigen::Vector3d origin_B;
    Eigen::Isometry3d X_WB;
    Eigen::Vector3d v_com_W, omega_W;
    Bounds bounds;
  };
  struct Force {
    ArmForce force;
    std::string with;
  };
  std::vector<Body> bodies;
  std::vector<GripperMechanism::State> grippers;
  std::vector<ArmLinks::State> arms;
  Simplification::State simplification;
  std::vector<ContactConstraint> touches;
  StepSolver::Memory solver;
  std::vector<std::vector<Force>> forces;
  int contacts = 0;
  double belt_speed = 0, next_belt_speed = 0, max_penetration = 0;
  std::uint64_t steps = 0, faults = 0;
};

PhysicsWorld::State PhysicsWorld::save() const {
  const PhysicsModel& cell = impl_->cell;
  State::Data data{.simplification = cell.simplification.save()};
  for (const auto& body : cell.bodies) {
    auto& to = data.bodies.emplace_back(
        State::Data::Body{{}, body.origin_B, body.X_WB, body.v_com_W, body.omega_W, body.bounds});
    ode::save(body.body.get(), to.ode);
  }
  for (const auto& gripper : cell.grippers) data.grippers.push_back(gripper.save());
  for (const auto& arm : cell.arms) data.arms.push_back(arm.save());
  data.touches = cell.touches;
  data.solver = impl_->solver.save();
  for (const auto& list : impl_->forces) {
    auto& to = data.forces.emplace_back();
    for (const auto& force : list) to.push_back({force, std::string(force.with)});
  }
  data.belt_speed = cell.belt_speed_m_s;
  data.next_belt_speed = impl_->next_belt_speed;
  data.max_penetration = impl_->max_penetration;
  data.contacts = impl_->contacts;
  data.steps = impl_->steps;
  data.faults = impl_->faults;
  State state;
  state.data_ = std::make_shared<const State::Data>(std::move(data));
  return state;
}

void PhysicsWorld::restore(const State& state) {
  PhysicsModel& cell = impl_->cell;
  if (!state.data_) throw std::invalid_argument("physics state: empty");
  const State::Data& data = *state.data_;
  if (data.bodies.size() != cell.bodies.size() || data.arms.size() != cell.arms.size()) {
    throw std::invalid_argument("physics state: of " + std::to_string(data.bodies.size()) +
                                " bodies and " + std::to_string(data.arms.size()) +
                                " robots, but the scene has " + std::to_string(cell.bodies.size()) +
                                " and " + std::to_string(cell.arms.size()));
  }
  cell.simplification.restore(data.simplification);
  for (std::size_t i = 0; i < data.bodies.size(); ++i) {
    const auto& from = data.bodies[i];
    FreeBody& body = cell.bodies[i];
    body.origin_B = from.origin_B;
    body.X_WB = from.X_WB;
    body.v_com_W = from.v_com_W;
    body.omega_W = from.omega_W;
    body.bounds = from.bounds;
    ode::restore(body.body.get(), from.ode);
    dBodyDisable(body.body.get());
  }
  for (std::size_t r = 0; r < data.arms.size(); ++r) {
    cell.arms[r].restore(data.arms[r]);
    cell.grippers[r].restore(data.grippers[r]);
    impl_->forces[r].clear();
    for (const auto& [force, with] : data.forces[r]) {
      impl_->forces[r].push_back(force);
      impl_->forces[r].back().with = name_in(cell, with);
    }
  }
  cell.touches = data.touches;
  impl_->solver.restore(data.solver);
  cell.belt_speed_m_s = data.belt_speed;
  impl_->next_belt_speed = data.next_belt_speed;
  impl_->max_penetration = data.max_penetration;
  impl_->contacts = data.contacts;
  impl_->steps = data.steps;
  impl_->faults = data.faults;
}

}  // namespace aprsim::physics
