#pragma once

#include <array>
#include <string_view>

namespace aprsim::protocols {

/// The protocol of a stream's first bytes if it is one of browsers (HTTP, TLS); empty = none.
/// Listeners for controllers close such connections: any web page can make its reader's browser
/// send them.
[[nodiscard]] inline std::string_view foreign_protocol(std::string_view first_bytes) {
  constexpr std::array<std::string_view, 10> kMethods{"GET ",     "POST ",     "PUT ",     "HEAD ",
                                                      "OPTIONS ", "PATCH ",    "CONNECT ", "TRACE ",
                                                      "DELETE",   "PRI * HTTP"};
  if (first_bytes.empty()) return {};
  for (const std::string_view method : kMethods) {
    // A stream may come in small pieces: its beginning decides.
    if (first_bytes.starts_with(method) || method.starts_with(first_bytes)) return "HTTP";
  }
  return first_bytes[0] == '\x16' ? "TLS" : "";
}

}  // namespace aprsim::protocols
