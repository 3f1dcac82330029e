#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "world/base/result.hpp"

namespace aprsim::protocols {

/// The latest part of a run as a journal file, for a replay elsewhere.
struct Incident {
  std::string name;  ///< suggested file name
  /// The file's bytes, one piece after the other.
  std::vector<std::shared_ptr<const std::string>> pieces;
};

class IncidentSource {
 public:
  using Done = std::function<void(Result<Incident>)>;

  virtual ~IncidentSource() = default;
  /// Delivers the run since the last checkpoint that is at least `last` of simulated time ago, or
  /// the oldest one kept. Calls `done` once, on a thread of its own, which `done` must not block.
  /// Errors: kFailedPrecondition (nothing is kept), kUnavailable (the daemon is stopping). Thread:
  /// any; never blocks.
  virtual void take_incident(std::chrono::nanoseconds last, Done done) = 0;
};

}  // namespace aprsim::protocols
