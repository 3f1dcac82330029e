#pragma once

#include <dds/dds.h>
#include <vector>

#include <google/protobuf/duration.pb.h>

#include "clients/ros2/cell/frames.hpp"
#include "clients/ros2/cell/joint_states.hpp"
#include "clients/ros2/dds/node.hpp"

/// Messages of ROS 2, written by a writer of the same type. Errors of DDS: std::runtime_error.
namespace aprsim::ros2 {

/// rosgraph_msgs/msg/Clock.
[[nodiscard]] TopicType clock_type();
/// sensor_msgs/msg/JointState.
[[nodiscard]] TopicType joint_state_type();
/// tf2_msgs/msg/TFMessage.
[[nodiscard]] TopicType tf_type();

/// `time`: simulated, since the last reset; in all functions.
void write_clock(dds_entity_t writer, const google::protobuf::Duration& time);
void write_joint_states(dds_entity_t writer, const google::protobuf::Duration& time,
                        const JointStates& states);
/// Frames in the world.
void write_frames(dds_entity_t writer, const google::protobuf::Duration& time,
                  const std::vector<Frame>& frames);

}  // namespace aprsim::ros2
