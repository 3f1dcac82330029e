#include "tests/support/shuttle.hpp"

#include <cmath>
#include <stdexcept>

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

constexpr double kCarrySpeed = 0.4, kCloseSpeed = 0.12;  // [m/s]
constexpr double kGripHeight = 0.004;                    // over the disc [m]
constexpr double kDropHeight = 5e-4;                     // over the slot [m]
constexpr double kLost = 3e-3;                           // off its slot [m]

const Eigen::Vector3d kUp(0, 0, 0.06), kNear(0, 0, 0.014);

std::size_t body_named(const api::CellDescription& cell, const std::string& name) {
  for (std::size_t i = 0; i < cell.bodies.size(); ++i) {
    if (cell.bodies[i].name == name) return i;
  }
  throw std::runtime_error("no body " + name);
}

api::SetMotionLimit speed(double m_s) { return {api::MotionLimit::kTransSpeed, false, m_s}; }

}  // namespace

Shuttle::Shuttle(const api::CellDescription& cell, int robot, const std::string& gear,
                 SlotName from, SlotName to)
    : robot_(robot), gear_(body_named(cell, gear)), from_(find(cell, from)), to_(find(cell, to)) {
  const auto& description = cell.robots.at(static_cast<std::size_t>(robot));
  X_RW_ = (description.X_WB.isometry() * description.X_BR.isometry()).inverse();
  grip_z_ = cell.bodies[gear_].disc_height_m + kGripHeight;
}

Shuttle::Place Shuttle::find(const api::CellDescription& cell, const SlotName& name) {
  const std::size_t tray = body_named(cell, name.tray);
  for (const auto& slot : cell.bodies[tray].slots) {
    if (slot.name == name.slot) return {tray, slot.X_PS.isometry()};
  }
  throw std::runtime_error("no slot " + name.slot + " in " + name.tray);
}

Eigen::Isometry3d Shuttle::X_WG(const api::Snapshot& now) const {
  return now.bodies[gear_].X_WB.isometry();
}

Eigen::Isometry3d Shuttle::X_WS(const api::Snapshot& now) const {
  return now.bodies[to_.tray].X_WB.isometry() * to_.X_PS;
}

api::MoveTo Shuttle::move(const Eigen::Vector3d& p_WT, bool straight) const {
  Eigen::Isometry3d X_WT = Eigen::Isometry3d::Identity();
  X_WT.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  X_WT.translation() = p_WT;
  return {Pose::from(X_RW_ * X_WT), straight};
}

std::optional<api::RobotAction> Shuttle::next(const api::Snapshot& now) {
  switch (stage_++) {
    case 0:
      return api::InitRobot{};
    case 1:
      return api::SetGripper{1};
    case 2:
      return speed(kCarrySpeed);
    case 3:
      p_W_ = X_WG(now) * Eigen::Vector3d(0, 0, grip_z_);
      return move(p_W_ + kUp, false);
    case 4:
      return speed(kCloseSpeed);
    case 5:
      return move(p_W_, true);
    case 6:
      return api::Dwell{50ms};
    case 7:
      return api::SetGripper{0};
    case 8:
      return api::Dwell{50ms};
    case 9:
      return move(p_W_ + kUp, true);
    case 10:
      return speed(kCarrySpeed);
    case 11: {
      // The tool goes where it brings the gear, as it now sits in the hand, over its slot.
      const Eigen::Vector3d p_WT =
          now.robots[static_cast<std::size_t>(robot_)].X_WT.isometry().translation();
      p_W_ = p_WT + X_WS(now) * Eigen::Vector3d(0, 0, kDropHeight) - X_WG(now).translation();
      return move(p_W_ + kUp, false);
    }
    case 12:
      return speed(kCloseSpeed);
    case 13:
      return move(p_W_ + kNear, true);
    case 14:
      return move(p_W_, true);
    case 15:
      return api::Dwell{50ms};
    case 16:
      return api::SetGripper{1};
    case 17:
      return api::Dwell{50ms};
    case 18:
      return move(p_W_ + kUp, true);
    default:
      return std::nullopt;
  }
}

void Shuttle::finish_trip(const api::Snapshot& now) {
  if ((X_WS(now).inverse() * X_WG(now)).translation().norm() > kLost) {
    throw std::runtime_error("robot " + std::to_string(robot_) + " lost its gear on trip " +
                             std::to_string(trips_ + 1));
  }
  std::swap(from_, to_);
  stage_ = 0;
  ++trips_;
}

}  // namespace aprsim::test
