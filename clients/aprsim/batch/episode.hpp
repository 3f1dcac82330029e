#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/scenario/run_result.hpp"
#include "clients/wires/outcome.hpp"
#include "world/scenario/plan.hpp"

namespace aprsim::client {

/// The stored result of one run of a batch. It holds no wall-clock time.
struct Episode {
  std::uint64_t seed = 0;
  bool as_expected = false;
  std::string end_reason;
  std::string state_hash;                ///< of the cell at the end
  std::vector<std::string> broken;       ///< violated bounds: "drops 1, expected 0"
  std::map<std::string, double> values;  ///< by measure; absent = not measured
  std::map<std::string, double> drawn;   ///< varied parameters, by name with unit
  bool operator==(const Episode&) const = default;
};

[[nodiscard]] Episode episode_of(const RunResult& run, const scenario::Plan& plan);
[[nodiscard]] nlohmann::ordered_json episode_json(const Episode& episode);
/// Failure: kUsage for JSON that is no episode.
[[nodiscard]] Outcome<Episode> episode_of(const nlohmann::json& json);

}  // namespace aprsim::client
