#pragma once

#include <string>
#include <string_view>

namespace aprsim::server::journal {

/// SHA-256 of the bytes, in hexadecimal digits. Thread: any.
[[nodiscard]] std::string sha256(std::string_view bytes);

}  // namespace aprsim::server::journal
