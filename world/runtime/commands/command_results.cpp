#include "world/runtime/commands/command_results.hpp"

#include <algorithm>
#include <new>

namespace aprsim::world {

void CommandResults::record(api::Ticket ticket, const Result<void>& result) {
  applied_ = std::max(applied_, ticket);
  if (result) return;
  try {
    failures_ = with_appended(failures_, {ticket, result.error()}, api::kMaxFailures);
  } catch (const std::bad_alloc&) {
    // Without memory the failure is not reported: its sender sees an applied command.
  }
}

void CommandResults::write(api::Snapshot& out) const {
  out.applied = applied_;
  out.failures = failures_;
}

}  // namespace aprsim::world
