#pragma once

#include <map>
#include <string>
#include <vector>

#include "aprsim/v1/cell.pb.h"
#include "aprsim/v1/snapshot.pb.h"
#include "clients/ros2/dds/node.hpp"

namespace aprsim::ros2 {

/// Publishes a cell: /clock, /joint_states of all robots, /ROBOT/joint_states of each, /tf and
/// /tf_static. Thread: one. Errors of DDS: std::runtime_error.
class CellPublisher {
 public:
  /// `ros_namespace`: before the names of joint states, "/" = none; the other topics are global.
  CellPublisher(Node& node, std::string ros_namespace);

  /// The writer of /tf.
  [[nodiscard]] dds_entity_t frames() const { return frames_; }
  /// The cell that snapshots belong to from now on. Publishes the fixed frames.
  void set_cell(const v1::CellDescription& cell);
  /// Publishes time and joints, and frames if asked. After set_cell().
  void publish(const v1::Snapshot& snapshot, bool with_frames);

 private:
  [[nodiscard]] std::string absolute(const std::string& name) const;
  void create_robot_writers();

  Node& node_;
  std::string namespace_;
  v1::CellDescription cell_;
  std::vector<std::vector<std::string>> joint_names_;      ///< by robot, in all robots' topic
  std::vector<std::vector<std::string>> own_joint_names_;  ///< by robot, in its own topic
  dds_entity_t clock_;
  dds_entity_t joints_;
  dds_entity_t frames_;
  dds_entity_t fixed_frames_;
  std::map<std::string, dds_entity_t> robot_joints_;  ///< by the robot's name
};

}  // namespace aprsim::ros2
