#pragma once

#include <array>
#include <string_view>

namespace aprsim::protocols {

/// The protocol that a stream's first bytes belong to, if it is one that browsers speak and that
/// has no business on a listener for controllers; empty = none. Any web page can make its reader's
/// browser send such bytes.
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
