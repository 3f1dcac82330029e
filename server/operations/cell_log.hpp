#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::server {

/// One line for the log.
struct CellLogLine {
  bool error = false;  ///< else a warning
  std::string text;
};

/// Finds events of the cell since the last call, also where snapshots were missed: the simulation
/// has stopped, virtual time waits or follows the wall clock, a part is lost, injected faults have
/// begun and ended, the solver has failed for the first time since a reset. Thread: one at a time.
class CellLog {
 public:
  [[nodiscard]] std::vector<CellLogLine> detect(const api::Snapshot& now);

 private:
  void forget();
  void detect_faults(const api::Snapshot& now, std::vector<CellLogLine>& out);
  void detect_devices(const api::Snapshot& now, std::vector<CellLogLine>& out);
  void detect_time(const api::VirtualTimeStatePtr& now, std::vector<CellLogLine>& out);

  std::uint64_t epoch_ = 0, world_stops_ = 0;
  std::vector<bool> lost_;
  std::vector<bool> failed_;       // devices
  api::InjectedFaultsPtr faults_;  // as last reported
  bool not_converged_ = false;
  api::VirtualTimeStatePtr time_;  // as last reported
};

}  // namespace aprsim::server
