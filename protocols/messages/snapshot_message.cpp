#include <algorithm>
#include <cstddef>

#include "protocols/messages/codecs.hpp"
#include "protocols/messages/state_hash.hpp"
#include "protocols/messages/write_message.hpp"
#include "world/api/snapshot/contact_names.hpp"
#include "world/api/snapshot/snapshot_fields.hpp"

namespace aprsim::protocols {
namespace {

const api::BodyDescription* body_at(int index, const api::CellDescription& cell) {
  const auto i = static_cast<std::size_t>(index);
  return index >= 0 && i < cell.bodies.size() ? &cell.bodies[i] : nullptr;
}

void write(const api::GripperSnapshot& gripper, const api::CellDescription& cell,
           v1::GripperState& message) {
  write_fields(gripper, message);
  const api::BodyDescription* held = body_at(gripper.held_body, cell);
  if (held == nullptr) return;
  message.set_held_body(held->name);
  message.set_held_index(static_cast<std::uint32_t>(gripper.held_body));
  message.set_held_kind(to_message(held->kind));
}

void write(const api::VisionFrame& frame, const api::CellDescription& cell,
           v1::VisionFrame& message) {
  write_fields(frame, message);
  for (const auto& seen : frame.detections) {
    const api::BodyDescription* body = body_at(seen.body, cell);
    if (body == nullptr) continue;
    auto& detection = *message.add_detections();
    write_fields(seen, detection);
    detection.set_body(body->name);
  }
}

void write(const api::MotionSnapshot& motion, std::size_t joints, v1::MotionState& message) {
  for (std::size_t i = 0; i < joints; ++i) {
    message.add_reference_rad(motion.reference_rad[i]);
    message.add_reference_rad_s(motion.reference_rad_s[i]);
  }
  if (!motion.ends) return;
  for (const api::StreamEnd& end : *motion.ends) write_fields(end, *message.add_ends());
}

void write(const api::RobotSnapshot& robot, const api::RobotDescription& description,
           const api::CellDescription& cell, v1::RobotState& message) {
  write_fields(robot, message);
  message.set_name(description.name);
  const std::size_t joints = std::min(description.joints.size(), robot.joints.size());
  for (std::size_t i = 0; i < joints; ++i) write_fields(robot.joints[i], *message.add_joints());
  write(robot.motion, joints, *message.mutable_motion());
  write(robot.gripper, cell, *message.mutable_gripper());
  write(robot.vision, cell, *message.mutable_vision());
}

void write(const api::ToolSnapshot& tool, const api::ToolDescription& description,
           v1::ToolState& message) {
  write_fields(tool, message);
  message.set_name(description.name);
}

void write(const api::ContactSide& side, const api::CellDescription& cell,
           v1::ContactSide& message) {
  const auto index = static_cast<std::uint32_t>(side.index);
  switch (side.kind) {
    case api::ContactSide::Kind::kBody:
      message.set_body(index);
      break;
    case api::ContactSide::Kind::kRobot:
      message.set_robot(index);
      if (index < cell.robots.size()) {
        message.set_part(api::part_name(cell.robots[index], side.part));
      }
      break;
    case api::ContactSide::Kind::kFixed:
      message.set_fixed(index);
      break;
    case api::ContactSide::Kind::kTool:
      message.set_tool(index);
      break;
  }
}

/// A contact or a robot's touch.
template <typename T, typename Message>
void write_pair(const T& pair, const api::CellDescription& cell, Message& message) {
  write_fields(pair, message);
  write(pair.first, cell, *message.mutable_first());
  write(pair.second, cell, *message.mutable_second());
}

void write_sample_time(v1::Snapshot& message) {
  const auto wall = std::chrono::duration_cast<std::chrono::nanoseconds>(
                        std::chrono::system_clock::now().time_since_epoch())
                        .count();
  message.mutable_sample_time()->set_seconds(wall / 1'000'000'000);
  message.mutable_sample_time()->set_nanos(static_cast<std::int32_t>(wall % 1'000'000'000));
}

using Entities = SnapshotParts::Entities;

bool is_among(const std::vector<bool>& chosen, std::size_t index) {
  return index < chosen.size() && chosen[index];
}

bool takes_part(const Entities* entities, const api::ContactSide& side) {
  const auto index = static_cast<std::size_t>(side.index);
  switch (side.kind) {
    case api::ContactSide::Kind::kBody:
      return is_among(entities->bodies, index);
    case api::ContactSide::Kind::kRobot:
      return is_among(entities->robots, index);
    case api::ContactSide::Kind::kTool:
      return is_among(entities->tools, index);
    case api::ContactSide::Kind::kFixed:
      break;
  }
  return false;
}

bool takes_part(const Entities* entities, const api::ContactSide& first,
                const api::ContactSide& second) {
  return entities == nullptr || takes_part(entities, first) || takes_part(entities, second);
}

void write_robots(const api::Snapshot& snapshot, const Entities* entities, v1::Snapshot& message) {
  const api::CellDescription& cell = *snapshot.cell;
  const std::size_t count = std::min(cell.robots.size(), snapshot.robots.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (entities != nullptr && !is_among(entities->robots, i)) continue;
    write(snapshot.robots[i], cell.robots[i], cell, *message.add_robots());
  }
}

void write_bodies(const api::Snapshot& snapshot, const Entities* entities, v1::Snapshot& message) {
  const api::CellDescription& cell = *snapshot.cell;
  const std::size_t count = std::min(cell.bodies.size(), snapshot.bodies.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (entities != nullptr && !is_among(entities->bodies, i)) continue;
    write_message(snapshot.bodies[i], cell.bodies[i], *message.add_bodies());
  }
}

void write_tools(const api::Snapshot& snapshot, const Entities* entities, v1::Snapshot& message) {
  const api::CellDescription& cell = *snapshot.cell;
  const std::size_t count = std::min(cell.tools.size(), snapshot.tools.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (entities != nullptr && !is_among(entities->tools, i)) continue;
    write(snapshot.tools[i], cell.tools[i], *message.add_tools());
  }
}

void write_devices(const api::Snapshot& snapshot, v1::Snapshot& message) {
  const auto& described = snapshot.cell->devices;
  const std::size_t count = std::min(described.size(), snapshot.devices.size());
  for (std::size_t i = 0; i < count; ++i) {
    const api::DeviceSnapshot& device = snapshot.devices[i];
    v1::DeviceState& out = *message.add_devices();
    write_fields(device, out);
    out.set_name(described[i].name);
    const std::size_t signals = std::min(described[i].signals.size(), device.signals.size());
    for (std::size_t s = 0; s < signals; ++s) {
      v1::SignalValue& signal = *out.add_signals();
      signal.set_name(described[i].signals[s]);
      signal.set_value(device.signals[s]);
    }
  }
}

void write_contacts(const api::Snapshot& snapshot, const Entities* entities,
                    v1::Snapshot& message) {
  for (const auto& contact : snapshot.contacts) {
    if (!takes_part(entities, contact.first, contact.second)) continue;
    write_pair(contact, *snapshot.cell, *message.add_contacts());
  }
}

void write_touches(const api::Snapshot& snapshot, const Entities* entities, v1::Snapshot& message) {
  if (!snapshot.unintended_contacts) return;
  for (const auto& touch : *snapshot.unintended_contacts) {
    if (!takes_part(entities, touch.first, touch.second)) continue;
    write_pair(touch, *snapshot.cell, *message.add_unintended_contacts());
  }
}

void write_faults(const api::Snapshot& snapshot, v1::Snapshot& message) {
  if (!snapshot.faults) return;
  for (const auto& fault : snapshot.faults->all) {
    write_message(fault, *message.add_injected_faults());
  }
}

}  // namespace

void write_message(const Eigen::Vector3d& vector, v1::Vector3& message) {
  write_value(vector, message);
}

void write_message(const Pose& pose, v1::Pose& message) { write_value(pose, message); }

void write_message(std::chrono::nanoseconds span, google::protobuf::Duration& message) {
  write_value(span, message);
}

void write_message(const api::StreamEnd& end, v1::StreamEnd& message) {
  write_fields(end, message);
}

void write_message(const api::BodySnapshot& body, const api::BodyDescription& description,
                   v1::BodyState& message) {
  write_fields(body, message);
  message.set_name(description.name);
  message.set_type(description.type);
  message.set_kind(to_message(description.kind));
}

void write_message(const api::ConveyorSnapshot& conveyor,
                   const api::ConveyorDescription& description, v1::ConveyorState& message) {
  write_fields(conveyor, message);
  const std::size_t eyes = std::min(description.photo_eyes.size(), conveyor.photo_eyes.size());
  for (std::size_t i = 0; i < eyes; ++i) {
    write_fields(conveyor.photo_eyes[i], *message.add_photo_eyes());
  }
}

void write_message(const api::LightCurtainSnapshot& curtain,
                   const api::LightCurtainDescription& description,
                   v1::LightCurtainState& message) {
  write_fields(curtain, message);
  const auto beams =
      std::min(static_cast<std::size_t>(description.beams), curtain.distance_m.size());
  for (std::size_t i = 0; i < beams; ++i) message.add_distance_m(curtain.distance_m[i]);
}

void write_message(const api::Snapshot& snapshot, const std::string& instance_id,
                   v1::Snapshot& message, const SnapshotParts& parts) {
  const api::CellDescription& cell = *snapshot.cell;
  const auto wanted = [&](int field) { return !parts.without[static_cast<std::size_t>(field)]; };
  write_fields(snapshot, message);
  message.set_instance_id(instance_id);
  write_sample_time(message);
  message.set_revision(cell.revision);
  const auto step_time = static_cast<std::int64_t>(snapshot.step_time_s * 1e9);
  write_value(std::chrono::nanoseconds(step_time), *message.mutable_step_time());
  if (const auto& time = snapshot.virtual_time) {
    message.mutable_virtual_time()->set_reproducible(time->reproducible());
  }
  if (wanted(v1::Snapshot::kRobotsFieldNumber)) write_robots(snapshot, parts.entities, message);
  if (cell.has_conveyor) {
    write_message(snapshot.conveyor, cell.conveyor, *message.mutable_conveyor());
  }
  if (cell.light_curtain) {
    write_message(snapshot.light_curtain, *cell.light_curtain, *message.mutable_light_curtain());
  }
  if (wanted(v1::Snapshot::kBodiesFieldNumber)) write_bodies(snapshot, parts.entities, message);
  if (wanted(v1::Snapshot::kToolsFieldNumber)) write_tools(snapshot, parts.entities, message);
  if (wanted(v1::Snapshot::kDevicesFieldNumber)) write_devices(snapshot, message);
  if (wanted(v1::Snapshot::kContactsFieldNumber)) write_contacts(snapshot, parts.entities, message);
  if (wanted(v1::Snapshot::kStateHashFieldNumber)) message.set_state_hash(state_hash(snapshot));
  if (wanted(v1::Snapshot::kUnintendedContactsFieldNumber)) {
    write_touches(snapshot, parts.entities, message);
  }
  if (wanted(v1::Snapshot::kInjectedFaultsFieldNumber)) write_faults(snapshot, message);
}

}  // namespace aprsim::protocols
