#pragma once

#include <span>
#include <string_view>

#include "protocols/access/role.hpp"

namespace aprsim::protocols {

/// A call of the daemon and the least role that may make it.
struct CallRole {
  /// "PACKAGE.SERVICE/METHOD" of gRPC, "aprsim.v1.ViewerRequest/FIELD" for a request of a page, or
  /// the path of a generated page.
  std::string_view call;
  Role role;
};

/// All calls over gRPC and from the page with their roles. A new method or request needs a row
/// here; a test compares the rows with the messages.
[[nodiscard]] std::span<const CallRole> call_roles();

/// The role that a call needs, with or without a leading slash; kAdmin for a call without a row.
[[nodiscard]] Role role_needed(std::string_view call);

}  // namespace aprsim::protocols
