#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace aprsim::bench {

struct Load {
  std::vector<double> round_trips_ms;
  std::size_t unanswered = 0;  ///< requests still open a second after the last was sent
  double duration_s = 0;       ///< in which requests were sent
};

/// So many well-behaved clients from one thread, each asking `rate_hz` times a second whether or
/// not it has been answered; with `stallers`, also a client that sends a byte a second and one that
/// never reads. Throws std::runtime_error when a well-behaved client loses its connection.
[[nodiscard]] Load drive(std::uint16_t port, std::size_t clients, double rate_hz, bool stallers,
                         std::chrono::seconds duration);

}  // namespace aprsim::bench
