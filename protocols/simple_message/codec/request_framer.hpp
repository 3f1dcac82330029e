#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "protocols/simple_message/codec/message_codec.hpp"

/// Cuts the bytes of a client into requests as each controller does: by the message's type, not by
/// its field `length`, which clients fill in wrongly. Pure.
namespace aprsim::simple_message {

/// The reader of the stream.
enum class Port : std::uint8_t {
  kMotoman,       ///< motion and I/O of MotoROS: every type has its size
  kFanucMotion,   ///< Karel: every message has a sequence number and ten joints
  kFanucGripper,  ///< words without a header
};

struct Cut {
  std::size_t size = 0;      ///< bytes of the first request; 0 = it is incomplete
  bool known_length = true;  ///< false: no such type; all bytes at hand count as one message, as
                             ///< the controller takes them
};

/// The first request of a stream. Messages of unknown types have the size that they state if that
/// is within kMaxMessageSize.
[[nodiscard]] Cut cut_request(std::span<const std::uint8_t> stream, Port port, ByteOrder order);

}  // namespace aprsim::simple_message
