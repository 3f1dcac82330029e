#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace aprsim::client {

/// One run of a sweep. Nothing in it tells of the wall clock.
struct SweepRun {
  std::uint64_t seed = 0;
  std::optional<std::string> failure;  ///< why there is no result
  bool as_expected = false;
  std::string ended;
  std::map<std::string, double> values;  ///< by measure; absent = nothing to tell
  std::string state_hash;                ///< of the cell at the end; empty = unknown
};

/// Many runs of one scenario with different seeds.
struct Sweep {
  std::string scenario;
  std::vector<SweepRun> runs;
};

/// The whole result: shares with confidence intervals, a distribution for each measure, each run.
/// The same runs in any order give the same text.
[[nodiscard]] nlohmann::ordered_json sweep_json(Sweep sweep);
/// The same for a terminal, without the single runs but for those that were not as expected.
[[nodiscard]] std::string sweep_table(Sweep sweep);

}  // namespace aprsim::client
