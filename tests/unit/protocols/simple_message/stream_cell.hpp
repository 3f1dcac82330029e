#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "tests/support/fake_cell.hpp"

namespace aprsim::simple_message::testing {

/// A fake cell whose robots accept streams at once, and move as the test says.
class StreamCell final : public api::CommandSink, public api::SnapshotSource {
 public:
  [[nodiscard]] Result<api::Ticket> submit(api::Command command) override {
    const auto ticket = cell_.submit(command);
    if (!ticket) return ticket;
    const auto* trajectory = std::get_if<api::TrajectoryCommand>(&command.body);
    const auto* robot = std::get_if<api::RobotCommand>(&command.body);
    cell_.publish([&](api::Snapshot& next) {
      if (!held_) next.applied = *ticket;
      if (trajectory != nullptr && !held_) {
        apply(next.robots[static_cast<std::size_t>(trajectory->robot)], trajectory->action,
              *ticket);
      }
      if (robot != nullptr && !held_) {
        apply(next.robots[static_cast<std::size_t>(robot->robot)], robot->action);
      }
    });
    return ticket;
  }
  [[nodiscard]] api::SnapshotPtr latest() const override { return cell_.latest(); }
  [[nodiscard]] api::SnapshotPtr wait_newer(
      const api::SnapshotPtr& seen, std::chrono::steady_clock::time_point deadline) const override {
    return cell_.wait_newer(seen, deadline);
  }
  [[nodiscard]] std::string problem() const override { return cell_.problem(); }

  test::FakeCell& cell() { return cell_; }
  void hold() { held_ = true; }
  /// Changes one robot.
  void change(int robot, const std::function<void(api::RobotSnapshot&)>& change) {
    cell_.publish(
        [&](api::Snapshot& next) { change(next.robots[static_cast<std::size_t>(robot)]); });
  }
  /// The commands of one kind of action, in their order.
  template <typename Action>
  [[nodiscard]] std::vector<Action> actions() const {
    std::vector<Action> found;
    const auto keep = [&](const auto& action) {
      if constexpr (std::is_same_v<std::decay_t<decltype(action)>, Action>) found.push_back(action);
    };
    for (const api::Command& command : cell_.commands()) {
      if (const auto* trajectory = std::get_if<api::TrajectoryCommand>(&command.body)) {
        std::visit(keep, trajectory->action);
      }
      if (const auto* robot = std::get_if<api::RobotCommand>(&command.body)) {
        std::visit(keep, robot->action);
      }
    }
    return found;
  }

 private:
  static void apply(api::RobotSnapshot& robot, const api::TrajectoryAction& action,
                    api::Ticket ticket) {
    api::MotionSnapshot& motion = robot.motion;
    if (const auto* claim = std::get_if<api::ClaimMotion>(&action)) {
      if (claim->reset) {
        motion.alarm.clear();
        robot.protective_stop = false;
      }
      if (motion.source != api::MotionSource::kNone || !motion.alarm.empty()) return;
      motion = {};
      motion.source = api::MotionSource::kStream;
      motion.phase = api::StreamPhase::kReady;
      motion.commander = claim->commander;
      motion.stream = ticket;
      robot.drives_on = true;
    } else if (const auto* points = std::get_if<api::AppendPoints>(&action)) {
      if (points->begins) motion.time = {};
      motion.end_time = points->points.back().time;
      motion.points_left += points->points.size();
      motion.phase = api::StreamPhase::kMoving;
    } else if (std::holds_alternative<api::AppendMove>(action)) {
      ++motion.points_left;
      motion.phase = api::StreamPhase::kMoving;
    } else if (std::holds_alternative<api::StopStream>(action)) {
      motion.points_left = 0;
      motion.end_time = motion.time;
      motion.phase = api::StreamPhase::kReady;
    } else if (const auto* pause = std::get_if<api::PauseStream>(&action)) {
      motion.phase = pause->paused ? api::StreamPhase::kPaused : api::StreamPhase::kMoving;
    } else if (const auto* release = std::get_if<api::ReleaseMotion>(&action)) {
      if (!release->when_done || motion.points_left == 0) motion = {};
    }
  }
  static void apply(api::RobotSnapshot& robot, const api::RobotAction& action) {
    if (const auto* gripper = std::get_if<api::SetGripper>(&action)) {
      robot.gripper.setting = gripper->setting;
    } else if (std::holds_alternative<api::StopMotion>(action)) {
      robot.motion = {};
      robot.drives_on = false;
    }
  }

  test::FakeCell cell_;
  std::atomic<bool> held_{false};
};

}  // namespace aprsim::simple_message::testing
