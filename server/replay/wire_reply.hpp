#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "server/replay/deviation.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/runtime/record/recorder.hpp"

namespace aprsim::server::journal {

/// Requests of one connection; what is more will get no reply.
inline constexpr std::size_t kMostUnanswered = 1000;

/// A recorded reply that can be worked out again: of one of the moments in a span.
struct WireReply {
  world::RunTime from, to;  ///< from the request to the reply
  /// How it is another one than would be given at this moment.
  std::function<Deviation(const api::Snapshot&)> deviation;
};

}  // namespace aprsim::server::journal
