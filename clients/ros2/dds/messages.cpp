#include "clients/ros2/dds/messages.hpp"

#include <aprsim_ros2_messages.h>
#include <aprsim_ros2_type_hashes.hpp>
#include <string>

#include "clients/ros2/dds/samples.hpp"

namespace aprsim::ros2 {
TopicType clock_type() {
  return {rosgraph_msgs_msg_dds__Clock__desc, type_hash::k_rosgraph_msgs_msg_Clock};
}
TopicType joint_state_type() {
  return {sensor_msgs_msg_dds__JointState__desc, type_hash::k_sensor_msgs_msg_JointState};
}
TopicType tf_type() {
  return {tf2_msgs_msg_dds__TFMessage__desc, type_hash::k_tf2_msgs_msg_TFMessage};
}

void write_clock(dds_entity_t writer, const google::protobuf::Duration& time) {
  const rosgraph_msgs_msg_dds__Clock_ message{stamp_of(time)};
  write_sample(writer, &message);
}

void write_joint_states(dds_entity_t writer, const google::protobuf::Duration& time,
                        const JointStates& states) {
  const std::string no_frame;
  std::vector<char*> names;
  for (const auto& name : states.name) names.push_back(text_of(name));
  sensor_msgs_msg_dds__JointState_ message{};
  message.header.stamp = stamp_of(time);
  message.header.frame_id = text_of(no_frame);
  refer(message.name, names);
  refer(message.position, states.position);
  refer(message.velocity, states.velocity);
  refer(message.effort, states.effort);
  write_sample(writer, &message);
}

void write_frames(dds_entity_t writer, const google::protobuf::Duration& time,
                  const std::vector<Frame>& frames) {
  const std::string world = kWorldFrame;
  std::vector<geometry_msgs_msg_dds__TransformStamped_> transforms;
  for (const auto& frame : frames) {
    auto& transform = transforms.emplace_back();
    transform.header.stamp = stamp_of(time);
    transform.header.frame_id = text_of(world);
    transform.child_frame_id = text_of(frame.name);
    const auto& position = frame.in_world.position_m();
    const auto& turn = frame.in_world.orientation();
    transform.transform.translation = {position.x(), position.y(), position.z()};
    transform.transform.rotation = {turn.x(), turn.y(), turn.z(), turn.w()};
  }
  tf2_msgs_msg_dds__TFMessage_ message{};
  refer(message.transforms, transforms);
  write_sample(writer, &message);
}

}  // namespace aprsim::ros2
