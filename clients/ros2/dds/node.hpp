#pragma once

#include <dds/dds.h>
#include <mutex>
#include <string>
#include <vector>

namespace aprsim::ros2 {

/// Whether a topic keeps its latest sample for readers that come later.
enum class Durability { kVolatile, kTransientLocal };

/// The qualities of service of a topic.
struct Quality {
  int depth = 10;  ///< samples that are kept for a slow reader
  Durability durability = Durability::kVolatile;
  bool reliable = true;
};

/// A type of DDS, and its hash as ROS 2 writes it.
struct TopicType {
  const dds_topic_descriptor_t& descriptor;
  const char* hash;
};

/// The two ends of a service.
struct ServiceEndpoints {
  dds_entity_t requests = 0;  ///< reader
  dds_entity_t replies = 0;   ///< writer
};

/// A participant of DDS that other participants know as one node of ROS 2. Thread: any. Errors of
/// DDS are thrown as std::runtime_error.
class Node {
 public:
  /// `ros_namespace`: absolute, "/" = none.
  Node(unsigned domain, std::string ros_namespace, std::string name);
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// A writer of a topic, by its name in ROS ("/clock"), which lives as long as the node.
  [[nodiscard]] dds_entity_t create_writer(const std::string& topic, const TopicType& type,
                                           const Quality& quality);
  /// The ends of a service, by its name in ROS, as ROS 2's CycloneDDS (rmw_cyclonedds_cpp) has
  /// them.
  [[nodiscard]] ServiceEndpoints create_service(const std::string& name, const TopicType& request,
                                                const TopicType& reply);
  /// Ends a reader or writer.
  void remove(dds_entity_t endpoint);
  /// Tells other nodes which readers and writers there are; after the last change.
  void announce();
  /// A set of conditions to wait for.
  [[nodiscard]] dds_entity_t create_waitset() const;
  /// A condition that another thread triggers.
  [[nodiscard]] dds_entity_t create_guard() const;

 private:
  dds_entity_t participant_ = 0;
  dds_entity_t announcements_ = 0;  ///< writer of ros_discovery_info
  std::string namespace_;
  std::string name_;
  std::mutex mutex_;  ///< of all below, and of announcements
  std::vector<dds_entity_t> readers_, writers_;
  unsigned services_ = 0;  ///< made so far
};

/// Whether somebody reads what a writer writes.
[[nodiscard]] bool has_readers(dds_entity_t writer);

/// Writes a sample. Throws std::runtime_error.
void write_sample(dds_entity_t writer, const void* sample);

/// The name of a topic in DDS, as ROS 2 has it: "rt" before its absolute name.
[[nodiscard]] std::string dds_topic_name(const std::string& topic);

}  // namespace aprsim::ros2
