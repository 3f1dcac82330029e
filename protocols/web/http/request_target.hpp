#pragma once

#include <span>
#include <string>
#include <string_view>

#include "world/base/result.hpp"

namespace aprsim::web {

/// Destination of an HTTP request, independent of the form of its target (RFC 9112, section 3.2).
struct RequestTarget {
  std::string host;   ///< with the port, as sent; empty = an HTTP/1.0 request without Host
  std::string path;   ///< percent-decoded, except for slashes and NUL
  std::string query;  ///< percent-decoded, without the question mark

  friend bool operator==(const RequestTarget&, const RequestTarget&) = default;
};

/// Reads the target of a request line and the values of all its Host lines. The host of an
/// absolute-form target replaces that of the Host line. `version` is 10 for HTTP/1.0, 11 for
/// HTTP/1.1. Errors: kInvalidArgument, where RFC 9112 demands status 400.
[[nodiscard]] Result<RequestTarget> read_target(std::string_view target,
                                                std::span<const std::string_view> hosts,
                                                unsigned version);

}  // namespace aprsim::web
