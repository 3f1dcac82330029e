#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "world/api/ports.hpp"

namespace aprsim::test_support {

/// A cell with a six-joint "fanuc", a seven-joint "motoman" and a belt, at rest.
inline std::shared_ptr<const api::CellDescription> two_robot_cell() {
  auto cell = std::make_shared<api::CellDescription>();
  cell->scene = "fake";
  cell->step_size = std::chrono::milliseconds(1);
  for (const auto& [name, joints] : {std::pair{"fanuc", 6}, std::pair{"motoman", 7}}) {
    api::RobotDescription& robot = cell->robots.emplace_back();
    robot.name = name;
    for (int i = 1; i <= joints; ++i) {
      robot.joints.push_back({"joint_" + std::to_string(i), -3, 3, 5, 50});
    }
    robot.gripper = {0.01, 0.06, 0.04, 50};
    robot.reach_min_R = Eigen::Vector3d::Constant(-10);
    robot.reach_max_R = Eigen::Vector3d::Constant(10);
    robot.max_trans_speed_m_s = 1;
    robot.max_trans_accel_m_s2 = 5;
    robot.max_rot_speed_rad_s = 3;
    robot.max_rot_accel_rad_s2 = 15;
  }
  cell->has_conveyor = true;
  cell->conveyor.length_m = 1;
  cell->conveyor.width_m = 0.2;
  cell->conveyor.max_speed_m_s = 0.3;
  cell->conveyor.max_accel_m_s2 = 1;
  return cell;
}

/// The two ways across the thread boundary without a simulation: records what is submitted, shows
/// whatever snapshot the test makes up. Nothing happens by itself. Thread: any.
class FakeWorld : public api::CommandSink, public api::SnapshotSource {
 public:
  explicit FakeWorld(std::shared_ptr<const api::CellDescription> cell = two_robot_cell()) {
    auto first = std::make_shared<api::Snapshot>();
    first->cell = cell;
    first->robots.resize(cell->robots.size());
    first->speed_target = 1.0;
    first->real_time_factor = 1.0;
    latest_ = std::move(first);
  }

  Result<api::Ticket> submit(api::Command command) override {
    const std::lock_guard lock(mutex_);
    if (refusal_) return tl::unexpected<Error>(*refusal_);
    commands_.push_back(std::move(command));
    changed_.notify_all();
    return commands_.size();
  }

  [[nodiscard]] api::SnapshotPtr latest() const override {
    const std::lock_guard lock(mutex_);
    return latest_;
  }

  [[nodiscard]] api::SnapshotPtr wait_newer(
      const api::SnapshotPtr& seen, std::chrono::steady_clock::time_point deadline) const override {
    std::unique_lock lock(mutex_);
    changed_.wait_until(lock, deadline, [&] { return latest_ != seen; });
    return latest_;
  }

  /// Publishes the next snapshot, one step later, with the test's changes.
  void publish(const std::function<void(api::Snapshot&)>& change) {
    const std::lock_guard lock(mutex_);
    auto next = std::make_shared<api::Snapshot>(*latest_);
    ++next->step;
    next->time += next->cell->step_size;
    change(*next);
    latest_ = std::move(next);
    changed_.notify_all();
  }

  /// Publishes that a robot has taken `ticket` and how far it is with it.
  void report(int robot, api::Ticket ticket, api::ActionState state,
              const std::string& description = "") {
    publish([&](api::Snapshot& next) {
      next.applied = std::max(next.applied, ticket);
      next.robots[static_cast<std::size_t>(robot)].action = {ticket, state, description};
    });
  }

  /// From now on submit() fails with this; nullopt: accepts again.
  void refuse(std::optional<Error> refusal) {
    const std::lock_guard lock(mutex_);
    refusal_ = std::move(refusal);
  }

  /// All commands so far; the one with ticket t is at t - 1.
  [[nodiscard]] std::vector<api::Command> commands() const {
    const std::lock_guard lock(mutex_);
    return commands_;
  }

  /// Waits until at least `count` commands have been submitted; false when that takes too long.
  [[nodiscard]] bool wait_for_commands(
      std::size_t count, std::chrono::milliseconds limit = std::chrono::seconds(10)) const {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, limit, [&] { return commands_.size() >= count; });
  }

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::vector<api::Command> commands_;
  api::SnapshotPtr latest_;
  std::optional<Error> refusal_;
};

}  // namespace aprsim::test_support
