#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "protocols/simple_message/codec/message.hpp"
#include "world/base/result.hpp"

/// Simple Messages as bytes and back. Pure.
namespace aprsim::simple_message {

/// Order of the bytes of integers and floats, both of 32 bits. The controller decides: Karel and
/// the FS100 use big.
enum class ByteOrder : std::uint8_t { kBig, kLittle };

inline constexpr std::size_t kWordSize = 4;                   ///< every number on the wire
inline constexpr std::size_t kLengthSize = kWordSize;         ///< the field `length`
inline constexpr std::size_t kHeaderSize = kLengthSize + 12;  ///< length, type, comm, reply
/// The longest message, that of four groups.
inline constexpr std::size_t kMaxMessageSize = kHeaderSize + 8 + kGroups * 132;

/// The header's fields as they came.
struct Header {
  std::int32_t length = 0;  ///< of what follows this field
  std::int32_t type = 0, communication = 0, reply = 0;
};

/// The whole message; `length` is that of its body.
[[nodiscard]] std::string encode(const Message& message, ByteOrder order);

/// The first kHeaderSize bytes. Error: fewer are there ("length").
[[nodiscard]] Result<Header> decode_header(std::span<const std::uint8_t> bytes, ByteOrder order);

/// A request or topic from its bytes, sized by its type; surplus bytes are ignored. A missing part
/// of the groups of TrajectoryPointsExtended reads as 0.
/// Errors: kUnimplemented "type" (unknown), kInvalidArgument "length" (too short), or the name of a
/// number that is not finite, "position[2]".
[[nodiscard]] Result<Message> decode_request(std::span<const std::uint8_t> bytes, ByteOrder order);

/// The same for what a controller sends: replies and states.
[[nodiscard]] Result<Message> decode_reply(std::span<const std::uint8_t> bytes, ByteOrder order);

/// Bytes of a request's body by its type; nullopt for a type that no request has.
[[nodiscard]] std::optional<std::size_t> request_body_size(MessageType type);

/// A word of the raw protocol of the Fanuc's gripper port.
[[nodiscard]] std::int32_t decode_word(std::span<const std::uint8_t, 4> bytes, ByteOrder order);
[[nodiscard]] std::string encode_word(std::int32_t word, ByteOrder order);

}  // namespace aprsim::simple_message
