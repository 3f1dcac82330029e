#include "protocols/simple_message/codec/request_framer.hpp"

namespace aprsim::simple_message {
namespace {

constexpr std::size_t kGroupSize = 132;

Cut cut_if_there(std::size_t size, std::span<const std::uint8_t> stream) {
  return {.size = stream.size() >= size ? size : 0};
}

/// Karel reads a sequence number and ten joints whatever the type says; velocity and duration only
/// of a point whose length counts them.
Cut cut_karel(const Header& header, std::span<const std::uint8_t> stream) {
  const std::size_t position = kHeaderSize + *request_body_size(MessageType::kJointPosition);
  const std::size_t point = kHeaderSize + *request_body_size(MessageType::kTrajectoryPoint);
  const bool long_form = header.type == static_cast<std::int32_t>(MessageType::kTrajectoryPoint) &&
                         header.length >= static_cast<std::int32_t>(point - kLengthSize);
  return cut_if_there(long_form ? point : position, stream);
}

/// A sender may leave out groups that it does not use; the length tells whether it has.
Cut cut_extended(const Header& header, std::span<const std::uint8_t> stream, ByteOrder order) {
  constexpr std::size_t kWhole = kMaxMessageSize;
  if (header.length == static_cast<std::int32_t>(kWhole - kLengthSize)) {
    return cut_if_there(kWhole, stream);
  }
  if (stream.size() < kHeaderSize + kWordSize) return {};
  const auto groups = decode_word(stream.subspan<kHeaderSize, kWordSize>(), order);
  if (groups < 0 || groups > static_cast<std::int32_t>(kGroups)) {
    return cut_if_there(kWhole, stream);
  }
  return cut_if_there(kHeaderSize + 2 * kWordSize + kGroupSize * static_cast<std::size_t>(groups),
                      stream);
}

Cut cut_motoman(const Header& header, std::span<const std::uint8_t> stream, ByteOrder order) {
  const auto type = static_cast<MessageType>(header.type);
  if (type == MessageType::kTrajectoryPointsExtended) return cut_extended(header, stream, order);
  if (const auto body = request_body_size(type)) return cut_if_there(kHeaderSize + *body, stream);
  constexpr auto kLeast = static_cast<std::int32_t>(kHeaderSize - kLengthSize);
  constexpr auto kMost = static_cast<std::int32_t>(kMaxMessageSize - kLengthSize);
  if (header.length < kLeast || header.length > kMost) {
    return {.size = stream.size(), .known_length = false};
  }
  return cut_if_there(kLengthSize + static_cast<std::size_t>(header.length), stream);
}

}  // namespace

Cut cut_request(std::span<const std::uint8_t> stream, Port port, ByteOrder order) {
  if (port == Port::kFanucGripper) return cut_if_there(kWordSize, stream);
  const auto header = decode_header(stream, order);
  if (!header) return {};
  return port == Port::kFanucMotion ? cut_karel(*header, stream)
                                    : cut_motoman(*header, stream, order);
}

}  // namespace aprsim::simple_message
