#include "clients/ros2/trajectory_actions.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <iostream>
#include <utility>

#include <fmt/format.h>

#include "clients/ros2/cell/names.hpp"
#include "clients/ros2/dds/trajectory_server.hpp"
#include "clients/ros2/trajectory/arm_controller.hpp"

namespace aprsim::ros2 {
namespace {

constexpr std::chrono::milliseconds kLongestSleep{100};  // replies may wait for their readers
constexpr const char* kController = "/joint_trajectory_controller/follow_joint_trajectory";

bool is_same(const v1::RobotDescription& a, const v1::RobotDescription& b) {
  return a.SerializeAsString() == b.SerializeAsString();
}

}  // namespace

/// An arm's goals and its action.
struct TrajectoryActions::Arm {
  std::uint64_t number;
  TrajectoryServer server;
  ArmController controller;
};

TrajectoryActions::TrajectoryActions(Node& node, std::string ros_namespace)
    : node_(node),
      namespace_(ros_namespace == "/" ? "" : std::move(ros_namespace)),
      wakeup_(node),
      thread_([this] { run(); }) {}

TrajectoryActions::~TrajectoryActions() {
  stopping_ = true;
  wakeup_.notify();
  thread_.join();
}

void TrajectoryActions::set_cell(const client::Endpoints& daemon, const v1::CellDescription& cell) {
  {
    const std::lock_guard lock(mutex_);
    daemon_ = daemon;
    connected_ = true;
    inbox_.cell = cell;
  }
  wakeup_.notify();
}

void TrajectoryActions::set_time(const google::protobuf::Duration& time) {
  const std::lock_guard lock(mutex_);
  now_ = time;
}

void TrajectoryActions::disconnect() {
  const std::lock_guard lock(mutex_);
  connected_ = false;
}

void TrajectoryActions::check() {
  const std::lock_guard lock(mutex_);
  if (error_) std::rethrow_exception(error_);
}

client::Endpoints TrajectoryActions::daemon() {
  const std::lock_guard lock(mutex_);
  return daemon_;
}

void TrajectoryActions::run() {
  try {
    while (!stopping_) {
      wakeup_.wait(kLongestSleep);
      work();
    }
  } catch (const std::exception&) {
    const std::lock_guard lock(mutex_);
    error_ = std::current_exception();
  }
  arms_.clear();  // ends the calls
}

void TrajectoryActions::work() {
  Inbox inbox;
  google::protobuf::Duration now;
  bool connected = false;
  {
    const std::lock_guard lock(mutex_);
    std::swap(inbox, inbox_);
    now = now_;
    connected = connected_;
  }
  if (inbox.cell) apply_cell(*inbox.cell);
  for (const auto& event : inbox.events) apply(event);
  for (const auto& arm : arms_) serve(*arm, now, connected);
}

void TrajectoryActions::apply_cell(const v1::CellDescription& cell) {
  std::vector<std::unique_ptr<Arm>> arms;
  for (const auto& robot : cell.robots()) {
    const auto old = std::ranges::find_if(
        arms_, [&](const auto& arm) { return arm && is_same(arm->controller.robot(), robot); });
    arms.push_back(old == arms_.end() ? nullptr : std::move(*old));
  }
  arms_.clear();  // their names may be used again
  for (int i = 0; i < cell.robots_size(); ++i) {
    auto& arm = arms[static_cast<std::size_t>(i)];
    if (!arm) arm = make_arm(cell.robots(i));
  }
  arms_ = std::move(arms);
  node_.announce();
}

std::unique_ptr<TrajectoryActions::Arm> TrajectoryActions::make_arm(
    const v1::RobotDescription& robot) {
  const std::uint64_t number = ++arms_made_;
  const auto start = [this, number](std::uint64_t call, auto request) {
    return std::make_unique<FollowCall>(
        daemon(), std::move(request), [this, number, call](FollowCall::Event event) {
          {
            const std::lock_guard lock(mutex_);
            inbox_.events.push_back({number, call, std::move(event)});
          }
          wakeup_.notify();
        });
  };
  const std::string action = namespace_ + "/" + ros_token(robot.name()) + kController;
  return std::unique_ptr<Arm>(new Arm{number, {node_, action, wakeup_}, {robot, start}});
}

void TrajectoryActions::apply(const CallEvent& event) {
  const auto found =
      std::ranges::find_if(arms_, [&](const auto& arm) { return arm->number == event.arm; });
  if (found == arms_.end()) return;
  Arm& arm = **found;
  if (const auto* feedback = std::get_if<v1::TrajectoryFeedback>(&event.event)) {
    const auto* const motion = arm.controller.motion_of(event.call);
    if (motion) arm.server.publish_feedback(motion->goal, motion->joint_names, *feedback);
  } else {
    arm.controller.handle(event.call, std::get<FollowEnd>(event.event));
  }
}

void TrajectoryActions::serve(Arm& arm, const google::protobuf::Duration& now, bool connected) {
  const auto accept = [&](const GoalId& id, const TrajectoryGoal& goal) {
    std::string why = connected ? arm.controller.accept(id, goal, now) : "the daemon is away";
    if (!why.empty()) {
      std::cerr << fmt::format("aprsim-ros2: {} refused a goal: {}\n",
                               arm.controller.robot().name(), why);
    }
    return why;
  };
  arm.server.serve(arm.controller, {accept, now});
  arm.controller.expire();
  arm.server.publish(arm.controller.goals());
}

}  // namespace aprsim::ros2
