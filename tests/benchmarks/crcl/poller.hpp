#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace aprsim::bench {

struct Polls {
  std::vector<double> round_trips_us;
  std::size_t bytes = 0;  ///< of one status
};

/// CRCL clients that ask for the status one after the other, each again `period` after it last
/// asked, or at once when its answer took longer.
class StatusPollers {
 public:
  StatusPollers(std::uint16_t port, std::size_t clients, std::chrono::microseconds period);
  ~StatusPollers();
  StatusPollers(StatusPollers&&) noexcept;

  /// For `duration` and until all is answered, all clients in this thread; adds to `polls`. Throws
  /// std::runtime_error when a connection ends or an answer does not come.
  void run(std::chrono::milliseconds duration, Polls& polls);

 private:
  class Poller;
  std::chrono::microseconds period_;
  std::vector<Poller> pollers_;
};

}  // namespace aprsim::bench
