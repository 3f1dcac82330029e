#pragma once

#include <chrono>
#include <cstdint>
#include <set>

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::protocols {

/// The delay of an injected fault that makes a wire late; 0 = there is none. Wall-clock time.
[[nodiscard]] inline std::chrono::nanoseconds injected_delay(const api::Snapshot& snapshot,
                                                             faults::Kind kind, int robot = -1) {
  const auto* fault = snapshot.faults ? snapshot.faults->active(kind, robot) : nullptr;
  if (fault == nullptr) return {};
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(api::InjectedFaults::value(*fault, "delay")));
}

/// Whether an injected fault is active.
[[nodiscard]] inline bool injected(const api::Snapshot& snapshot, faults::Kind kind,
                                   int robot = -1) {
  return snapshot.faults && snapshot.faults->active(kind, robot) != nullptr;
}

/// Reports each momentary fault once, also where snapshots were missed. Faults of a saved state
/// that was loaded count as over. Thread: one at a time.
class MomentaryFaults {
 public:
  MomentaryFaults(faults::Kind kind, int robot) : kind_(kind), robot_(robot) {}

  /// Whether one has happened since the last call.
  [[nodiscard]] bool happened(const api::Snapshot& snapshot) {
    const bool loaded = snapshot.epoch != epoch_ && snapshot.loaded_state;
    if (snapshot.epoch != epoch_) seen_.clear();
    epoch_ = snapshot.epoch;
    if (!snapshot.faults) return false;
    bool any = false;
    for (const api::InjectedFault& fault : snapshot.faults->all) {
      if (fault.kind != kind_ || fault.robot != robot_ || !fault.begin_step) continue;
      any = seen_.insert(fault.id).second || any;
    }
    return any && !loaded;
  }

 private:
  faults::Kind kind_;
  int robot_;
  std::uint64_t epoch_ = 0;
  std::set<std::uint64_t> seen_;
};

}  // namespace aprsim::protocols
