#include "world/devices/action_list.hpp"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace aprsim::devices {
namespace {

constexpr double kLargest = 1e6;     // of speeds, forces and torques
constexpr double kFarthest_m = 1e3;  // no place of a cell is further from zero
constexpr double kUnitError = 1e-6;  // of the length of a quaternion

double bounded(double value, double most, const char* what) {
  if (std::abs(value) <= most) return value;
  throw std::invalid_argument(std::string(what) + " is " + std::to_string(value) +
                              ", expected a number of at most " + std::to_string(most));
}

Eigen::Vector3d vector_of(const device::Vector3& v, double most, const char* what) {
  return {bounded(v.x, most, what), bounded(v.y, most, what), bounded(v.z, most, what)};
}

int index_of(std::size_t index, std::size_t count, const char* what) {
  if (index < count) return static_cast<int>(index);
  throw std::invalid_argument(std::string(what) + ' ' + std::to_string(index) + " of a cell with " +
                              std::to_string(count));
}

}  // namespace

void ActionList::add(Action action) {
  if (actions_.size() - begin_ >= kMaxActions) {
    throw std::invalid_argument("more than " + std::to_string(kMaxActions) +
                                " commands in one step");
  }
  actions_.push_back(std::move(action));
}

int ActionList::body_index(std::size_t body) const {
  return index_of(body, names_.bodies.size(), "body");
}

int ActionList::robot_index(std::size_t robot) const {
  return index_of(robot, names_.robots.size(), "robot");
}

void ActionList::require_belt() const {
  if (!names_.has_belt) throw std::invalid_argument("a command to the belt of a cell without one");
}

void ActionList::run_belt(double speed_m_s) {
  require_belt();
  add(RunBelt{bounded(speed_m_s, kLargest, "the belt's speed")});
}

void ActionList::stop_belt() {
  require_belt();
  add(StopBelt{});
}

void ActionList::set_gripper(std::size_t robot, double setting) {
  if (!(setting >= 0 && setting <= 1)) {
    throw std::invalid_argument("a gripper's setting is " + std::to_string(setting) +
                                ", expected 0 to 1");
  }
  add(SetGripper{robot_index(robot), setting});
}

void ActionList::stop_robot(std::size_t robot) { add(StopRobot{robot_index(robot)}); }

void ActionList::push(std::size_t body, const device::Vector3& force_n,
                      const device::Vector3& torque_nm) {
  add(Push{body_index(body), vector_of(force_n, kLargest, "a force"),
           vector_of(torque_nm, kLargest, "a torque")});
}

void ActionList::place(std::size_t body, const device::Pose& pose) {
  const Eigen::Quaterniond q(pose.qw, pose.qx, pose.qy, pose.qz);
  if (!(std::abs(q.norm() - 1) <= kUnitError)) {
    throw std::invalid_argument("a pose's quaternion has the length " + std::to_string(q.norm()) +
                                ", expected 1");
  }
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.linear() = q.normalized().toRotationMatrix();
  X_WB.translation() = vector_of(pose.position, kFarthest_m, "a position");
  add(Place{body_index(body), X_WB});
}

void ActionList::remove(std::size_t body) { add(Remove{body_index(body)}); }

}  // namespace aprsim::devices
