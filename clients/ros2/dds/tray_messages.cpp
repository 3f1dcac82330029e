#include "clients/ros2/dds/tray_messages.hpp"

#include <aprsim_ros2_messages.h>
#include <aprsim_ros2_type_hashes.hpp>
#include <string>

#include "clients/ros2/dds/samples.hpp"

namespace aprsim::ros2 {
namespace {

using RosTray = aprs_interfaces_msg_dds__Tray_;
using RosSlot = aprs_interfaces_msg_dds__SlotInfo_;

geometry_msgs_msg_dds__PoseStamped_ stamped(const v1::Pose& pose, const std::string& frame,
                                            const google::protobuf::Duration& time) {
  const auto& p = pose.position_m();
  const auto& q = pose.orientation();
  geometry_msgs_msg_dds__PoseStamped_ out{};
  out.header.stamp = stamp_of(time);
  out.header.frame_id = text_of(frame);
  out.pose.position = {p.x(), p.y(), p.z()};
  out.pose.orientation = {q.x(), q.y(), q.z(), q.w()};
  return out;
}

/// Slots that refer to the tray.
std::vector<RosSlot> slots_of(const SeenTray& tray, const google::protobuf::Duration& time) {
  std::vector<RosSlot> slots;
  for (const auto& slot : tray.slots) {
    slots.push_back({.occupied = slot.occupied,
                     .size = slot.size,
                     .name = text_of(slot.name),
                     .slot_pose = stamped(slot.in_tray, tray.name, time)});
  }
  return slots;
}

}  // namespace

TopicType trays_type() {
  return {aprs_interfaces_msg_dds__Trays__desc, type_hash::k_aprs_interfaces_msg_Trays};
}

void write_trays(dds_entity_t writer, const google::protobuf::Duration& time,
                 const std::vector<SeenTray>& trays) {
  const std::string world = kWorldFrame;
  std::vector<std::vector<RosSlot>> slots;
  for (const auto& tray : trays) slots.push_back(slots_of(tray, time));
  std::vector<RosTray> kits, parts;
  for (std::size_t i = 0; i < trays.size(); ++i) {
    auto& out = (trays[i].is_kit ? kits : parts).emplace_back();
    out.identifier = trays[i].identifier;
    out.name = text_of(trays[i].name);
    out.tray_pose = stamped(trays[i].in_world, world, time);
    refer(out.slots, slots[i]);
  }
  aprs_interfaces_msg_dds__Trays_ message{};
  refer(message.kit_trays, kits);
  refer(message.part_trays, parts);
  write_sample(writer, &message);
}

}  // namespace aprsim::ros2
