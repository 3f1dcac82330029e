#include "clients/ros2/dds/trajectory_messages.hpp"

#include <algorithm>
#include <aprsim_ros2_messages.h>
#include <aprsim_ros2_type_hashes.hpp>
#include <string>

#include "clients/ros2/dds/goal_ids.hpp"
#include "clients/ros2/dds/samples.hpp"

namespace aprsim::ros2 {
namespace {

GoalPoint point_of(const trajectory_msgs_msg_dds__JointTrajectoryPoint_& point) {
  return {.positions = numbers_of(point.positions),
          .velocities = numbers_of(point.velocities),
          .accelerations = numbers_of(point.accelerations),
          .effort = numbers_of(point.effort),
          .time_from_start = time_of(point.time_from_start)};
}

template <typename Sequence>
std::vector<GoalTolerance> tolerances_of(const Sequence& sequence) {
  std::vector<GoalTolerance> tolerances;
  for (const auto& tolerance : values_of(sequence)) {
    tolerances.push_back(
        {tolerance.name, tolerance.position, tolerance.velocity, tolerance.acceleration});
  }
  return tolerances;
}

TrajectoryGoal goal_of(const control_msgs_action_dds__FollowJointTrajectory_Goal_& sample) {
  TrajectoryGoal goal;
  goal.start = time_of(sample.trajectory.header.stamp);
  for (const char* name : values_of(sample.trajectory.joint_names)) {
    goal.joint_names.emplace_back(name);
  }
  for (const auto& point : values_of(sample.trajectory.points)) {
    goal.points.push_back(point_of(point));
  }
  goal.path_tolerance = tolerances_of(sample.path_tolerance);
  goal.goal_tolerance = tolerances_of(sample.goal_tolerance);
  goal.goal_time_tolerance = time_of(sample.goal_time_tolerance);
  goal.has_multi_dof = sample.multi_dof_trajectory.joint_names._length > 0 ||
                       sample.multi_dof_trajectory.points._length > 0 ||
                       sample.component_path_tolerance._length > 0 ||
                       sample.component_goal_tolerance._length > 0;
  return goal;
}

using Numbers = google::protobuf::RepeatedField<double>;

/// A point that refers to these numbers.
trajectory_msgs_msg_dds__JointTrajectoryPoint_ point_of(const std::vector<double>& positions,
                                                        const std::vector<double>& velocities,
                                                        const google::protobuf::Duration& time) {
  trajectory_msgs_msg_dds__JointTrajectoryPoint_ point{};
  refer(point.positions, positions);
  refer(point.velocities, velocities);
  const auto stamp = stamp_of(time);
  point.time_from_start = {stamp.sec, stamp.nanosec};
  return point;
}

std::vector<double> as_vector(const Numbers& numbers) { return {numbers.begin(), numbers.end()}; }

std::vector<double> difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) out.push_back(a[i] - b[i]);
  return out;
}

GoalId read_result_request(const void* sample) {
  const auto& request =
      *static_cast<const control_msgs_action_dds__FollowJointTrajectory_GetResult_Request_*>(
          sample);
  return id_of(request.goal_id);
}

void write_goal_reply(dds_entity_t writer, const ServiceHeader& header, bool accepted,
                      const google::protobuf::Duration& stamp) {
  const control_msgs_action_dds__FollowJointTrajectory_SendGoal_Response_ reply{
      header.client, header.sequence, accepted, stamp_of(stamp)};
  write_sample(writer, &reply);
}

void write_result_reply(dds_entity_t writer, const ServiceHeader& header, GoalState state,
                        const ActionResult& result) {
  control_msgs_action_dds__FollowJointTrajectory_GetResult_Response_ reply{};
  reply.rmw_client = header.client;
  reply.rmw_sequence = header.sequence;
  reply.status = static_cast<char>(state);
  reply.result.error_code = result.error_code;
  reply.result.error_string = text_of(result.error_string);
  write_sample(writer, &reply);
}

}  // namespace

ActionMessages trajectory_messages() {
  return {
      .send_goal_request =
          {control_msgs_action_dds__FollowJointTrajectory_SendGoal_Request__desc,
           type_hash::k_control_msgs_action_FollowJointTrajectory_SendGoal_Request},
      .send_goal_reply = {control_msgs_action_dds__FollowJointTrajectory_SendGoal_Response__desc,
                          type_hash::k_control_msgs_action_FollowJointTrajectory_SendGoal_Response},
      .get_result_request =
          {control_msgs_action_dds__FollowJointTrajectory_GetResult_Request__desc,
           type_hash::k_control_msgs_action_FollowJointTrajectory_GetResult_Request},
      .get_result_reply =
          {control_msgs_action_dds__FollowJointTrajectory_GetResult_Response__desc,
           type_hash::k_control_msgs_action_FollowJointTrajectory_GetResult_Response},
      .feedback = {control_msgs_action_dds__FollowJointTrajectory_FeedbackMessage__desc,
                   type_hash::k_control_msgs_action_FollowJointTrajectory_FeedbackMessage},
      .read_result_request = read_result_request,
      .write_goal_reply = write_goal_reply,
      .write_result_reply = write_result_reply};
}

TrajectoryRequest read_trajectory_goal(const void* sample) {
  const auto& request =
      *static_cast<const control_msgs_action_dds__FollowJointTrajectory_SendGoal_Request_*>(sample);
  return {id_of(request.goal_id), goal_of(request.goal)};
}

void write_trajectory_feedback(dds_entity_t writer, const GoalId& id,
                               const std::vector<std::string>& joint_names,
                               const v1::TrajectoryFeedback& feedback) {
  const auto desired = as_vector(feedback.desired_rad());
  const auto desired_speed = as_vector(feedback.desired_rad_s());
  const auto actual = as_vector(feedback.actual_rad());
  const auto actual_speed = as_vector(feedback.actual_rad_s());
  const auto error = difference(desired, actual);
  const auto error_speed = difference(desired_speed, actual_speed);
  const std::string no_frame;
  std::vector<char*> names;
  for (const auto& name : joint_names) names.push_back(text_of(name));
  control_msgs_action_dds__FollowJointTrajectory_FeedbackMessage_ message{};
  message.goal_id = uuid_of(id);
  message.feedback.header.stamp = stamp_of(feedback.sim_time());
  message.feedback.header.frame_id = text_of(no_frame);
  refer(message.feedback.joint_names, names);
  message.feedback.desired = point_of(desired, desired_speed, feedback.time());
  message.feedback.actual = point_of(actual, actual_speed, feedback.time());
  message.feedback.error = point_of(error, error_speed, feedback.time());
  write_sample(writer, &message);
}

}  // namespace aprsim::ros2
