#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "clients/aprsim/batch/batch_directory.hpp"
#include "clients/wires/outcome.hpp"

namespace aprsim::client {

struct BatchOptions {
  std::string scenario;  ///< name or file
  std::vector<std::uint64_t> seeds;
  std::string directory;
  unsigned jobs = 1;       ///< at once
  unsigned tries = 3;      ///< of a seed, before it is given up
  unsigned journals = 3;   ///< of the worst ones
  std::string controller;  ///< in place of the scenario's own program; empty = that
  bool again = false;      ///< that controller takes one job after the other
};

/// What became of a batch.
struct BatchOutcome {
  Batch batch;
  Attempts attempts;
  std::size_t run_now = 0;  ///< episodes of this call
  double wall_s = 0;
  std::vector<std::pair<std::uint64_t, std::string>> given_up;  ///< seeds, and why
};

/// Runs a scenario with many seeds in virtual time: as many workers as jobs, each with a daemon
/// and a controller that are used again for the next seed. Seeds that the directory has are not run
/// again; an episode that fails for another reason than its outcome is tried again. After each
/// episode the directory holds it, and every few seconds the report of all so far; the worst are
/// run once more in the end, for their journals. `progress`: takes a line that is written in place
/// where `in_place`; null = nothing. Failures: a wrong scenario or directory; an interruption,
/// after which the directory is in order.
[[nodiscard]] Outcome<BatchOutcome> run_batch(const BatchOptions& options, std::ostream* progress,
                                              bool in_place);

}  // namespace aprsim::client
