#pragma once

#include <string_view>

#include "protocols/record/wire_tap.hpp"
#include "protocols/simple_message/codec/message_codec.hpp"

namespace aprsim::simple_message {

/// A message as an event of the tap, its bytes in hexadecimal. States, reads and their replies are
/// polls. Source, peer and time are unset. Thread: any.
[[nodiscard]] protocols::WireEvent wire_event(std::string_view bytes, bool from_client,
                                              ByteOrder order);

}  // namespace aprsim::simple_message
