#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "server/replay/deviation.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/runtime/record/recorder.hpp"

namespace aprsim::server::journal {

/// Limit of requests of one connection that wait for a reply.
inline constexpr std::size_t kMostUnanswered = 1000;

/// A recorded reply that can be recomputed for the moments in a span.
struct WireReply {
  world::RunTime from, to;  ///< from the request to the reply
  /// Its deviation from the reply at a moment.
  std::function<Deviation(const api::Snapshot&)> deviation;
};

/// The deviation of a reply of a robot that the cell does not have then.
[[nodiscard]] inline Deviation missing_robot(const std::string& robot) {
  Deviation all;
  all.word("robot " + robot, "there", "missing");
  return all;
}

}  // namespace aprsim::server::journal
