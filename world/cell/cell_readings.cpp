#include "world/cell/cell_readings.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace aprsim::world {

CellReadings::CellReadings(const CellSettings& settings, std::span<const SimulatedRobot> robots,
                           const physics::PhysicsWorld& physics, const ConveyorDrive* conveyor,
                           const sensors::PhotoEyes* photo_eyes)
    : settings_(settings),
      robots_(robots),
      physics_(physics),
      conveyor_(conveyor),
      photo_eyes_(photo_eyes) {}

GripFacts CellReadings::grip(int robot) const {
  return {physics_.gripper(robot).held_body, robot_at(robot).gripper_told_to_open()};
}

const std::string& CellReadings::type_of(int body) const {
  return settings_.bodies[static_cast<std::size_t>(body)].type;
}

bool CellReadings::beam_broken(int eye) const {
  return photo_eyes_ != nullptr && photo_eyes_->eyes()[static_cast<std::size_t>(eye)].broken;
}

double CellReadings::quantity(faults::Quantity quantity, int robot, int joint) const {
  using faults::Quantity;
  switch (quantity) {
    case Quantity::kJointPosition:
      return robot_at(robot).q()[joint];
    case Quantity::kToolHeight:
      return robot_at(robot).X_WT().translation().z();
    case Quantity::kToolForce:
      return robot_at(robot).tool_force_R(physics_.arm_forces(robot)).norm();
    case Quantity::kGripForce: {
      const physics::GripperState grip = physics_.gripper(robot);
      return std::min(grip.force_n[0], grip.force_n[1]);
    }
    case Quantity::kSeparation:
      return physics_.gripper(robot).separation_m;
    case Quantity::kBeltTravel:
      return conveyor_->state().travel_m;
    case Quantity::kBeltSpeed:
      return conveyor_->state().speed_m_s;
  }
  throw std::invalid_argument("no quantity of a cell");
}

std::optional<double> CellReadings::distance_to_belt_end(int body) const {
  const physics::BodyState state = physics_.body(body);
  const double speed = conveyor_->state().speed_m_s;
  const Pose X_WB{state.p_WB, state.q_WB};
  // A tray's origin is on its top face, no higher above the belt than a part that it carries.
  if (state.lost_step || speed == 0 || !photo_eyes_->carries(X_WB)) return std::nullopt;
  const scene::Conveyor& belt = *settings_.conveyor;
  const double x_C = (belt.X_WC.isometry().inverse() * X_WB.p).x();
  return 0.5 * belt.length_m - std::copysign(1.0, speed) * x_C;
}

}  // namespace aprsim::world
