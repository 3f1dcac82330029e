#include "clients/ros2/publisher.hpp"

#include <algorithm>
#include <utility>

#include "clients/ros2/cell/frames.hpp"
#include "clients/ros2/cell/joint_states.hpp"
#include "clients/ros2/cell/names.hpp"
#include "clients/ros2/dds/messages.hpp"

namespace aprsim::ros2 {
namespace {

constexpr int kFramesDepth = 100;

}  // namespace

CellPublisher::CellPublisher(Node& node, std::string ros_namespace)
    : node_(node),
      namespace_(std::move(ros_namespace)),
      clock_(node.create_writer("/clock", clock_type(), {})),
      joints_(node.create_writer(absolute("joint_states"), joint_state_type(), {})),
      frames_(node.create_writer("/tf", tf_type(), {.depth = kFramesDepth})),
      fixed_frames_(node.create_writer("/tf_static", tf_type(), {1, Durability::kTransientLocal})) {
  node.announce();
}

std::string CellPublisher::absolute(const std::string& name) const {
  return (namespace_ == "/" ? "" : namespace_) + "/" + name;
}

void CellPublisher::set_cell(const v1::CellDescription& cell) {
  cell_ = cell;
  joint_names_ = joint_names(cell);
  own_joint_names_.clear();
  for (const auto& robot : cell.robots()) {
    auto& names = own_joint_names_.emplace_back();
    for (const auto& joint : robot.joints()) names.push_back(joint.name());
  }
  create_robot_writers();
  write_frames(fixed_frames_, {}, fixed_frames(cell));
}

void CellPublisher::create_robot_writers() {
  for (auto it = robot_joints_.begin(); it != robot_joints_.end();) {
    const bool stays = std::ranges::any_of(
        cell_.robots(), [&](const auto& robot) { return robot.name() == it->first; });
    if (!stays) node_.remove(it->second);
    it = stays ? std::next(it) : robot_joints_.erase(it);
  }
  for (const auto& robot : cell_.robots()) {
    if (robot_joints_.contains(robot.name())) continue;
    const std::string topic = absolute(ros_token(robot.name()) + "/joint_states");
    robot_joints_[robot.name()] = node_.create_writer(topic, joint_state_type(), {});
  }
  node_.announce();
}

void CellPublisher::publish(const v1::Snapshot& snapshot, bool with_frames) {
  const auto& time = snapshot.sim_time();
  write_clock(clock_, time);
  JointStates all;
  const auto robots =
      std::min<std::size_t>(joint_names_.size(), static_cast<std::size_t>(snapshot.robots_size()));
  for (std::size_t i = 0; i < robots; ++i) {
    const auto& robot = snapshot.robots(static_cast<int>(i));
    append_joints(all, robot, joint_names_[i]);
    JointStates own;
    append_joints(own, robot, own_joint_names_[i]);
    const auto writer = robot_joints_.find(robot.name());
    if (writer != robot_joints_.end()) write_joint_states(writer->second, time, own);
  }
  write_joint_states(joints_, time, all);
  if (with_frames) write_frames(frames_, time, moving_frames(cell_, snapshot));
}

}  // namespace aprsim::ros2
