#include "clients/aprsim/trace/simple_message_units.hpp"

#include <cstdint>
#include <span>

#include "protocols/simple_message/codec/message_codec.hpp"
#include "protocols/simple_message/codec/request_framer.hpp"

namespace aprsim::trace {
namespace {

using namespace simple_message;

constexpr ByteOrder kWireOrder = ByteOrder::kBig;

/// Words of the Fanuc's gripper are 0 to 3, and 99 to end. No message is as short or has that
/// length.
bool is_gripper_word(std::int32_t word) { return (word >= 0 && word <= 3) || word == 99; }

/// Karel's points have a sequence number and joints; the types of MotoROS are others.
Port port_of(const Header& header) {
  const auto type = static_cast<MessageType>(header.type);
  const bool karel = type == MessageType::kJointPosition || type == MessageType::kTrajectoryPoint;
  return karel ? Port::kFanucMotion : Port::kMotoman;
}

}  // namespace

std::optional<std::size_t> simple_message_unit(std::string_view bytes, bool from_client) {
  const std::span<const std::uint8_t> stream(reinterpret_cast<const std::uint8_t*>(bytes.data()),
                                             bytes.size());
  if (stream.size() < kWordSize) return 0;
  if (is_gripper_word(decode_word(stream.first<kWordSize>(), kWireOrder))) return kWordSize;
  const auto header = decode_header(stream, kWireOrder);
  if (!header) return 0;
  constexpr auto kLeast = static_cast<std::int32_t>(kHeaderSize - kLengthSize);
  constexpr auto kMost = static_cast<std::int32_t>(kMaxMessageSize - kLengthSize);
  if (header->length < kLeast || header->length > kMost) return std::nullopt;
  if (from_client) {
    const Cut cut = cut_request(stream, port_of(*header), kWireOrder);
    if (!cut.known_length) return std::nullopt;
    return cut.size;
  }
  const std::size_t size = kLengthSize + static_cast<std::size_t>(header->length);
  return bytes.size() < size ? 0 : size;
}

}  // namespace aprsim::trace
