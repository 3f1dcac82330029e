#pragma once

#include <chrono>
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
  unsigned jobs = 1;                   ///< parallel runs
  unsigned tries = 3;                  ///< attempts per seed
  unsigned journals = 3;               ///< of the worst seeds
  std::string controller;              ///< shell command; empty = the scenario's program
  bool reuse_controller = false;       ///< the controller takes one job after the other
  std::chrono::seconds patience{600};  ///< without progress, before a run is given up
};

/// Result of a batch.
struct BatchOutcome {
  Batch batch;
  Attempts attempts;
  std::size_t run_now = 0;  ///< runs of this call
  double wall_s = 0;
  std::vector<std::pair<std::uint64_t, std::string>> given_up;  ///< seeds, and why
};

/// Runs a scenario with many seeds in virtual time. Each of `jobs` workers reuses a daemon and a
/// controller. Seeds with a stored result are skipped; a run that fails for another reason than
/// its outcome is repeated. Every result is stored at once, and the report every few seconds. The
/// worst seeds are rerun in the end to record their journals. `progress` receives a progress line,
/// rewritten in place if `in_place`; null = none. Failures: a wrong scenario or directory; an
/// interruption, which leaves the directory consistent.
[[nodiscard]] Outcome<BatchOutcome> run_batch(const BatchOptions& options, std::ostream* progress,
                                              bool in_place);

}  // namespace aprsim::client
