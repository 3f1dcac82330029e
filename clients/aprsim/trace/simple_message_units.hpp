#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace aprsim::trace {

/// Size of the first unit of a Simple Message port of either controller: a message, or a word of
/// the Fanuc's gripper. 0 = more bytes are needed; nullopt = no unit begins so. Pure.
[[nodiscard]] std::optional<std::size_t> simple_message_unit(std::string_view bytes,
                                                             bool from_client);

}  // namespace aprsim::trace
