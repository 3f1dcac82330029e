#pragma once

#include <dds/dds.h>
#include <string>
#include <vector>

namespace aprsim::ros2 {

/// Whether a topic keeps its latest sample for readers that come later.
enum class Durability { kVolatile, kTransientLocal };

/// A type of DDS, and its hash as ROS 2 writes it.
struct TopicType {
  const dds_topic_descriptor_t& descriptor;
  const char* hash;
};

/// A participant of DDS that other participants know as one node of ROS 2. Thread: one. Errors of
/// DDS are thrown as std::runtime_error.
class Node {
 public:
  /// `ros_namespace`: absolute, "/" = none.
  Node(unsigned domain, std::string ros_namespace, std::string name);
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// A reliable writer of a topic, by its name in ROS ("/clock"), which lives as long as the node.
  [[nodiscard]] dds_entity_t create_writer(const std::string& topic, const TopicType& type,
                                           int depth, Durability durability);
  /// Ends a writer.
  void remove_writer(dds_entity_t writer);
  /// Tells other nodes which writers there are; after the last change.
  void announce();

 private:
  dds_entity_t participant_ = 0;
  dds_entity_t announcements_ = 0;  ///< writer of ros_discovery_info
  std::string namespace_;
  std::string name_;
  std::vector<dds_entity_t> writers_;
};

/// Writes a sample. Throws std::runtime_error.
void write_sample(dds_entity_t writer, const void* sample);

/// The name of a topic in DDS, as ROS 2 has it: "rt" before its absolute name.
[[nodiscard]] std::string dds_topic_name(const std::string& topic);

}  // namespace aprsim::ros2
