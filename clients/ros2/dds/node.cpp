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

Qos make_qos(const Quality& quality, const std::string& user_data) {
  Qos qos(dds_create_qos(), &dds_delete_qos);
  dds_qset_reliability(qos.get(),
                       quality.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       quality.reliable ? DDS_INFINITY : 0);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, quality.depth);
  dds_qset_durability(qos.get(), quality.durability == Durability::kVolatile
                                     ? DDS_DURABILITY_VOLATILE
                                     : DDS_DURABILITY_TRANSIENT_LOCAL);
  if (!user_data.empty()) dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  return qos;
}

std::string hash_entry(const TopicType& type) { return fmt::format("typehash={};", type.hash); }

dds_entity_t make_topic(dds_entity_t participant, const std::string& topic, const TopicType& type) {
  return checked(dds_create_topic(participant, &type.descriptor, topic.c_str(), nullptr, nullptr),
                 "create topic " + topic);
}

dds_entity_t make_writer(dds_entity_t participant, const std::string& topic, const TopicType& type,
                         const Qos& qos) {
  const dds_entity_t handle = make_topic(participant, topic, type);
  const dds_entity_t writer = dds_create_writer(participant, handle, qos.get(), nullptr);
  dds_delete(handle);  // the writer keeps it
  return checked(writer, "create a writer of " + topic);
}

dds_entity_t make_reader(dds_entity_t participant, const std::string& topic, const TopicType& type,
                         const Qos& qos) {
  const dds_entity_t handle = make_topic(participant, topic, type);
  const dds_entity_t reader = dds_create_reader(participant, handle, qos.get(), nullptr);
  dds_delete(handle);  // the reader keeps it
  return checked(reader, "create a reader of " + topic);
}

/// The identifier that joins the ends of a service: bytes in hexadecimal with dots between.
std::string service_entry(dds_entity_t participant, unsigned number) {
  dds_guid_t guid;
  checked(dds_get_guid(participant, &guid), "read an entity's identifier");
  std::string text = "serviceid=";
  for (std::size_t i = 0; i < 12; ++i) text += fmt::format("{:x}.", guid.v[i]);
  return text + fmt::format("{:x}.{:x}.{:x}.{:x};", number >> 24 & 0xff, number >> 16 & 0xff,
                            number >> 8 & 0xff, number & 0xff);
}

rmw_dds_common_msg_dds__Gid_ gid_of(dds_entity_t entity) {
  dds_guid_t guid;
  rmw_dds_common_msg_dds__Gid_ gid;
  checked(dds_get_guid(entity, &guid), "read an entity's identifier");
  static_assert(sizeof(guid.v) == sizeof(gid.data));
  std::memcpy(gid.data, guid.v, sizeof(gid.data));
  return gid;
}

std::vector<rmw_dds_common_msg_dds__Gid_> gids_of(const std::vector<dds_entity_t>& entities) {
  std::vector<rmw_dds_common_msg_dds__Gid_> gids;
  gids.reserve(entities.size());
  for (const dds_entity_t entity : entities) gids.push_back(gid_of(entity));
  return gids;
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
                               make_qos({1, Durability::kTransientLocal}, {}));
}

Node::~Node() { dds_delete(participant_); }

dds_entity_t Node::create_writer(const std::string& topic, const TopicType& type,
                                 const Quality& quality) {
  const auto qos = make_qos(quality, hash_entry(type));
  const std::lock_guard lock(mutex_);
  writers_.push_back(make_writer(participant_, dds_topic_name(topic), type, qos));
  return writers_.back();
}

ServiceEndpoints Node::create_service(const std::string& name, const TopicType& request,
                                      const TopicType& reply) {
  const std::lock_guard lock(mutex_);
  const std::string id = service_entry(participant_, ++services_);
  ServiceEndpoints ends;
  ends.replies =
      make_writer(participant_, "rr" + name + "Reply", reply, make_qos({}, id + hash_entry(reply)));
  writers_.push_back(ends.replies);
  ends.requests = make_reader(participant_, "rq" + name + "Request", request,
                              make_qos({}, id + hash_entry(request)));
  readers_.push_back(ends.requests);
  return ends;
}

void Node::remove(dds_entity_t endpoint) {
  const std::lock_guard lock(mutex_);
  std::erase(writers_, endpoint);
  std::erase(readers_, endpoint);
  dds_delete(endpoint);
}

dds_entity_t Node::create_waitset() const {
  return checked(dds_create_waitset(participant_), "create a waitset");
}

dds_entity_t Node::create_guard() const {
  return checked(dds_create_guardcondition(participant_), "create a guard condition");
}

void Node::announce() {
  const std::lock_guard lock(mutex_);
  auto writers = gids_of(writers_);
  auto readers = gids_of(readers_);
  rmw_dds_common_msg_dds__NodeEntitiesInfo_ node{};
  set_text(node.node_namespace, namespace_);
  set_text(node.node_name, name_);
  node.writer_gid_seq._buffer = writers.data();
  node.writer_gid_seq._length = node.writer_gid_seq._maximum =
      static_cast<std::uint32_t>(writers.size());
  node.reader_gid_seq._buffer = readers.data();
  node.reader_gid_seq._length = node.reader_gid_seq._maximum =
      static_cast<std::uint32_t>(readers.size());
  rmw_dds_common_msg_dds__ParticipantEntitiesInfo_ info{};
  info.gid = gid_of(participant_);
  info.node_entities_info_seq._buffer = &node;
  info.node_entities_info_seq._length = info.node_entities_info_seq._maximum = 1;
  write_sample(announcements_, &info);
}

bool has_readers(dds_entity_t writer) {
  return checked(dds_get_matched_subscriptions(writer, nullptr, 0), "count readers") > 0;
}

void write_sample(dds_entity_t writer, const void* sample) {
  checked(dds_write(writer, sample), "write a sample");
}

std::string dds_topic_name(const std::string& topic) { return "rt" + topic; }

}  // namespace aprsim::ros2
