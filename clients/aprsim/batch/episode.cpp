#include "clients/aprsim/batch/episode.hpp"

#include <nlohmann/json.hpp>

namespace aprsim::client {

Episode episode_of(const RunResult& run, const scenario::Plan& plan) {
  Episode out{.seed = run.seed,
              .as_expected = run.as_expected(),
              .end_reason = run.end_reason,
              .state_hash = run.state_hash,
              .values = run.measured.values,
              .drawn = plan.drawn};
  for (const Verdict& verdict : run.verdicts) {
    if (!verdict.kept) out.broken.push_back(text_of(verdict));
  }
  return out;
}

nlohmann::ordered_json episode_json(const Episode& episode) {
  return {{"seed", episode.seed},
          {"as_expected", episode.as_expected},
          {"end_reason", episode.end_reason},
          {"state_hash", episode.state_hash},
          {"broken", episode.broken},
          {"values", episode.values},
          {"drawn", episode.drawn}};
}

Outcome<Episode> episode_of(const nlohmann::json& json) {
  try {
    return Episode{.seed = json.at("seed"),
                   .as_expected = json.at("as_expected"),
                   .end_reason = json.at("end_reason"),
                   .state_hash = json.at("state_hash"),
                   .broken = json.at("broken"),
                   .values = json.at("values"),
                   .drawn = json.at("drawn")};
  } catch (const nlohmann::json::exception& error) {
    return failed(FailureKind::kUsage, std::string("no episode: ") + error.what());
  }
}

}  // namespace aprsim::client
