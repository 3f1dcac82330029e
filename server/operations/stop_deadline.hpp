#pragma once

#include <chrono>
#include <functional>
#include <memory>

namespace aprsim::server {

/// Limits the time from a signal to the end of the process. After `patience` it calls `finish`,
/// which saves data that must not be lost, and ends the process with exit code 0, after another
/// `last_patience` in any case. Once this is destroyed, `finish` is not called any more, but the
/// process still ends in time. Thread: the owner's.
class StopDeadline {
 public:
  explicit StopDeadline(std::function<void()> finish,
                        std::chrono::milliseconds patience = std::chrono::milliseconds(2000),
                        std::chrono::milliseconds last_patience = std::chrono::milliseconds(700));
  ~StopDeadline();
  StopDeadline(const StopDeadline&) = delete;
  StopDeadline& operator=(const StopDeadline&) = delete;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace aprsim::server
