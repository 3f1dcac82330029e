#include "clients/ros2/dds/node.hpp"

#include <algorithm>
#include <aprsim_ros2_messages.h>
#include <aprsim_ros2_type_hashes.hpp>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace aprsim::ros2 {
namespace {

using Qos = std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)>;

dds_entity_t checked(dds_entity_t result, const std::string& action) {
  if (result >= 0) return result;
  throw std::runtime_error(fmt::format("cannot {}: {}", action, dds_strretcode(result)));
}

Qos make_qos(int depth, Durability durability, const std::string& user_data) {
  Qos qos(dds_create_qos(), &dds_delete_qos);
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  dds_qset_durability(qos.get(), durability == Durability::kVolatile
                                     ? DDS_DURABILITY_VOLATILE
                                     : DDS_DURABILITY_TRANSIENT_LOCAL);
  if (!user_data.empty()) dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  return qos;
}

dds_entity_t make_writer(dds_entity_t participant, const std::string& topic, const TopicType& type,
                         const Qos& qos) {
  const dds_entity_t handle =
      checked(dds_create_topic(participant, &type.descriptor, topic.c_str(), nullptr, nullptr),
              "create topic " + topic);
  const dds_entity_t writer = dds_create_writer(participant, handle, qos.get(), nullptr);
  dds_delete(handle);  // the writer keeps it
  return checked(writer, "create a writer of " + topic);
}

rmw_dds_common_msg_dds__Gid_ gid_of(dds_entity_t entity) {
  dds_guid_t guid;
  rmw_dds_common_msg_dds__Gid_ gid;
  checked(dds_get_guid(entity, &guid), "read an entity's identifier");
  static_assert(sizeof(guid.v) == sizeof(gid.data));
  std::memcpy(gid.data, guid.v, sizeof(gid.data));
  return gid;
}

void set_text(char (&field)[257], const std::string& text) {
  const auto length = std::min(text.size(), sizeof(field) - 1);
  std::memcpy(field, text.data(), length);
  field[length] = 0;
}

}  // namespace

Node::Node(unsigned domain, std::string ros_namespace, std::string name)
    : namespace_(std::move(ros_namespace)), name_(std::move(name)) {
  const Qos qos(dds_create_qos(), &dds_delete_qos);
  const std::string enclave = "enclave=/;";
  dds_qset_userdata(qos.get(), enclave.data(), enclave.size());
  participant_ = checked(dds_create_participant(domain, qos.get(), nullptr),
                         fmt::format("join DDS domain {}", domain));
  announcements_ = make_writer(participant_, "ros_discovery_info",
                               {rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc,
                                type_hash::k_rmw_dds_common_msg_ParticipantEntitiesInfo},
                               make_qos(1, Durability::kTransientLocal, {}));
}

Node::~Node() { dds_delete(participant_); }

dds_entity_t Node::create_writer(const std::string& topic, const TopicType& type, int depth,
                                 Durability durability) {
  const auto qos = make_qos(depth, durability, fmt::format("typehash={};", type.hash));
  writers_.push_back(make_writer(participant_, dds_topic_name(topic), type, qos));
  return writers_.back();
}

void Node::remove_writer(dds_entity_t writer) {
  std::erase(writers_, writer);
  dds_delete(writer);
}

void Node::announce() {
  std::vector<rmw_dds_common_msg_dds__Gid_> writers;
  writers.reserve(writers_.size());
  for (const dds_entity_t writer : writers_) writers.push_back(gid_of(writer));
  rmw_dds_common_msg_dds__NodeEntitiesInfo_ node{};
  set_text(node.node_namespace, namespace_);
  set_text(node.node_name, name_);
  node.writer_gid_seq._buffer = writers.data();
  node.writer_gid_seq._length = node.writer_gid_seq._maximum =
      static_cast<std::uint32_t>(writers.size());
  rmw_dds_common_msg_dds__ParticipantEntitiesInfo_ info{};
  info.gid = gid_of(participant_);
  info.node_entities_info_seq._buffer = &node;
  info.node_entities_info_seq._length = info.node_entities_info_seq._maximum = 1;
  write_sample(announcements_, &info);
}

void write_sample(dds_entity_t writer, const void* sample) {
  checked(dds_write(writer, sample), "write a sample");
}

std::string dds_topic_name(const std::string& topic) { return "rt" + topic; }

}  // namespace aprsim::ros2
