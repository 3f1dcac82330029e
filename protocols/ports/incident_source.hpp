#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "world/base/result.hpp"

namespace aprsim::protocols {

/// The latest of a run as a journal file, which can be run again elsewhere.
struct Incident {
  std::string name;  ///< of a file
  /// The file's bytes, one piece after the other.
  std::vector<std::shared_ptr<const std::string>> pieces;
};

class IncidentSource {
 public:
  using Done = std::function<void(Result<Incident>)>;

  virtual ~IncidentSource() = default;
  /// All from the last checkpoint that is `last` of simulated time or more back, or from the oldest
  /// that is kept, up to now. Calls `done` once, from a thread of its own, which must not wait
  /// there. Errors: kFailedPrecondition (nothing is kept), kUnavailable (it ends). Thread: any;
  /// never waits.
  virtual void take_incident(std::chrono::nanoseconds last, Done done) = 0;
};

}  // namespace aprsim::protocols
