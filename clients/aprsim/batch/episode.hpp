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

/// What success is called among outcomes.
inline constexpr const char* kAsExpected = "as_expected";

/// One run of a batch, as it is kept. Nothing in it tells of the wall clock.
struct Episode {
  std::uint64_t seed = 0;
  bool as_expected = false;
  std::string ended;                     ///< why
  std::string state_hash;                ///< of the cell at the end
  std::vector<std::string> broken;       ///< bounds that were not kept: "drops 1, expected 0"
  std::map<std::string, double> values;  ///< by measure; absent = nothing to tell
  std::map<std::string, double> drawn;   ///< what varied, by its name with its unit
  bool operator==(const Episode&) const = default;
};

[[nodiscard]] Episode episode_of(const RunResult& run, const scenario::Plan& plan);
[[nodiscard]] nlohmann::ordered_json episode_json(const Episode& episode);
/// Failure: kUsage when it is no episode.
[[nodiscard]] Outcome<Episode> episode_of(const nlohmann::json& json);

}  // namespace aprsim::client
