#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace aprsim::bench {

/// Round trips of `clients` CRCL clients that ask for the status one after the other, each again
/// `period` after it last asked, or at once when its answer took longer.
struct Polls {
  std::vector<double> round_trips_us;
  std::size_t bytes = 0;  ///< of one status
};

/// Runs for `duration`, all clients in one thread. Throws std::runtime_error when a connection
/// ends.
[[nodiscard]] Polls poll_statuses(std::uint16_t port, std::size_t clients,
                                  std::chrono::microseconds period, std::chrono::seconds duration);

}  // namespace aprsim::bench
