#pragma once

#include <span>
#include <string_view>

#include "protocols/access/role.hpp"

namespace aprsim::protocols {

/// A way of asking the daemon for something, and the least role that may.
struct CallRole {
  /// "PACKAGE.SERVICE/METHOD" of gRPC, "aprsim.v1.ViewerRequest/FIELD" for what a page may ask, or
  /// the path of a page that is made when it is asked for.
  std::string_view call;
  Role role;
};

/// Every call over gRPC and from the page: the one place that says who may what. Whoever adds a
/// method or a request adds its row; a test compares it with the messages.
[[nodiscard]] std::span<const CallRole> call_roles();

/// Role that a call needs, with or without a slash before it; kAdmin for one without a row.
[[nodiscard]] Role role_needed(std::string_view call);

}  // namespace aprsim::protocols
