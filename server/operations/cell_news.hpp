#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::server {

/// One line for the log.
struct NewsLine {
  bool error = false;  ///< else a warning
  std::string text;
};

/// Tells what has happened to the cell since it was last looked at, whatever was missed in between:
/// the simulation has stopped, virtual time stands or goes by the wall clock, a part is lost,
/// injected faults have begun and ended, the solver has failed for the first time since a reset.
/// Thread: one at a time.
class CellNews {
 public:
  [[nodiscard]] std::vector<NewsLine> look(const api::Snapshot& now);

 private:
  void forget();
  void look_at_faults(const api::Snapshot& now, std::vector<NewsLine>& out);
  void look_at_time(const api::VirtualTimeStatePtr& now, std::vector<NewsLine>& out);

  std::uint64_t epoch_ = 0, world_stops_ = 0;
  std::vector<bool> lost_;
  api::InjectedFaultsPtr faults_;  // as last told of
  bool not_converged_ = false;
  api::VirtualTimeStatePtr time_;  // as last told of
};

}  // namespace aprsim::server
