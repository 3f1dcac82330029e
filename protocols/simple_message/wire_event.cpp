#include "protocols/simple_message/wire_event.hpp"

#include <cstdint>
#include <span>
#include <string>

#include <fmt/format.h>

namespace aprsim::simple_message {
namespace {

struct Named {
  const char* name;
  bool poll;
};

/// A state or a read changes nothing.
Named named(MessageType type) {
  switch (type) {
    case MessageType::kPing:
      return {"Ping", true};
    case MessageType::kJointPosition:
      return {"JointPosition", false};
    case MessageType::kTrajectoryPoint:
      return {"TrajectoryPoint", false};
    case MessageType::kRobotStatus:
      return {"RobotStatus", true};
    case MessageType::kTrajectoryPointFull:
      return {"TrajectoryPointFull", false};
    case MessageType::kJointFeedback:
      return {"JointFeedback", true};
    case MessageType::kMotionControl:
      return {"MotionControl", false};
    case MessageType::kMotionReply:
      return {"MotionReply", false};
    case MessageType::kReadIoBit:
    case MessageType::kReadIoGroup:
    case MessageType::kReadRegister:
      return {"ReadIo", true};
    case MessageType::kReadIoBitReply:
    case MessageType::kReadIoGroupReply:
      return {"ReadIoReply", true};
    case MessageType::kWriteIoBit:
    case MessageType::kWriteIoGroup:
    case MessageType::kWriteRegister:
      return {"WriteIo", false};
    case MessageType::kWriteIoBitReply:
    case MessageType::kWriteIoGroupReply:
      return {"WriteIoReply", false};
    case MessageType::kTrajectoryPointsExtended:
      return {"TrajectoryPointsExtended", false};
    case MessageType::kJointFeedbackExtended:
      return {"JointFeedbackExtended", true};
    case MessageType::kSelectTool:
      return {"SelectTool", false};
    case MessageType::kDhParameters:
      return {"DhParameters", true};
  }
  return {"", false};
}

std::string hexadecimal(std::string_view bytes) {
  std::string out;
  for (const char byte : bytes) out += fmt::format("{:02x}", static_cast<std::uint8_t>(byte));
  return out;
}

}  // namespace

protocols::WireEvent wire_event(std::string_view bytes, bool from_client, ByteOrder order) {
  protocols::WireEvent event{.from_client = from_client, .data = hexadecimal(bytes)};
  const std::span<const std::uint8_t> data(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                                           bytes.size());
  const auto header = decode_header(data, order);
  if (!header) {
    event.type = "Gripper";
    return event;
  }
  const auto [name, poll] = named(static_cast<MessageType>(header->type));
  const bool topic = header->communication == static_cast<std::int32_t>(Communication::kTopic);
  event.type = *name != '\0' ? name : fmt::format("type {}", header->type);
  event.poll = poll || (topic && !from_client);
  return event;
}

}  // namespace aprsim::simple_message
