#pragma once

#include <algorithm>

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::protocols {

/// The error of a command that the snapshot includes; null = it succeeded. Thread: any.
[[nodiscard]] inline const Error* failure_of(const api::Snapshot& snapshot, api::Ticket ticket) {
  if (!snapshot.failures) return nullptr;
  const auto found = std::ranges::find(*snapshot.failures, ticket, &api::CommandFailure::ticket);
  return found == snapshot.failures->end() ? nullptr : &found->error;
}

}  // namespace aprsim::protocols
