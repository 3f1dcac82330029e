#pragma once

#include "world/api/snapshot/snapshot.hpp"
#include "world/base/result.hpp"
#include "world/base/with_appended.hpp"

namespace aprsim::world {

/// The latest command that has taken effect, and the latest ones that failed. Thread: sim.
class CommandResults {
 public:
  /// After a command has been applied, with its ticket.
  void record(api::Ticket ticket, const Result<void>& result);

  /// Writes Snapshot::applied and Snapshot::failures.
  void write(api::Snapshot& out) const;

 private:
  api::Ticket applied_ = 0;
  SharedList<api::CommandFailure> failures_;
};

}  // namespace aprsim::world
