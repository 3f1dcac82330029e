#include "clients/aprsim/sweep/sweep_report.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/sweep/distribution.hpp"

namespace aprsim::client {
namespace {

using SweepJson = nlohmann::ordered_json;

struct Totals {
  std::size_t finished = 0, as_expected = 0;
  std::map<std::string, Distribution> measures;
};

Totals totals_of(const Sweep& sweep) {
  Totals out;
  std::map<std::string, std::vector<double>> values;
  for (const SweepRun& run : sweep.runs) {
    if (run.failure) continue;
    ++out.finished;
    if (run.as_expected) ++out.as_expected;
    for (const auto& [measure, value] : run.values) values[measure].push_back(value);
  }
  for (auto& [measure, all] : values) out.measures[measure] = distribution_of(std::move(all));
  return out;
}

void sort_by_seed(Sweep& sweep) { std::ranges::sort(sweep.runs, {}, &SweepRun::seed); }

SweepJson json_of(const Interval& interval) {
  return SweepJson::array({interval.low, interval.high});
}

SweepJson json_of(const Distribution& d) {
  return {{"runs", d.count},          {"mean", d.mean}, {"mean_95", json_of(d.mean_95)},
          {"deviation", d.deviation}, {"min", d.min},   {"p05", d.p05},
          {"median", d.median},       {"p95", d.p95},   {"max", d.max}};
}

SweepJson json_of(const SweepRun& run) {
  if (run.failure) return {{"seed", run.seed}, {"failure", *run.failure}};
  return {{"seed", run.seed},
          {"as_expected", run.as_expected},
          {"ended", run.ended},
          {"state_hash", run.state_hash},
          {"values", run.values}};
}

}  // namespace

SweepJson sweep_json(Sweep sweep) {
  sort_by_seed(sweep);
  const Totals totals = totals_of(sweep);
  SweepJson out{{"scenario", sweep.scenario},
                {"runs", sweep.runs.size()},
                {"failed", sweep.runs.size() - totals.finished},
                {"as_expected", totals.as_expected}};
  if (totals.finished > 0) {
    out["as_expected_share_95"] = json_of(share_95(totals.as_expected, totals.finished));
  }
  out["measures"] = SweepJson::object();
  for (const auto& [measure, all] : totals.measures) out["measures"][measure] = json_of(all);
  out["each"] = SweepJson::array();
  for (const SweepRun& run : sweep.runs) out["each"].push_back(json_of(run));
  return out;
}

std::string sweep_table(Sweep sweep) {
  sort_by_seed(sweep);
  const Totals totals = totals_of(sweep);
  std::string out = fmt::format("{}: {} runs, {} as expected", sweep.scenario, sweep.runs.size(),
                                totals.as_expected);
  if (totals.finished > 0) {
    const Interval share = share_95(totals.as_expected, totals.finished);
    out += fmt::format(" (95 % of such sweeps: {:.1f} to {:.1f} %)", 100 * share.low,
                       100 * share.high);
  }
  out += fmt::format("\n\n{:<28} {:>5} {:>11} {:>25} {:>11} {:>11} {:>11} {:>11}\n", "measure",
                     "runs", "mean", "95 % interval of it", "min", "median", "p95", "max");
  for (const auto& [measure, d] : totals.measures) {
    const std::string interval = fmt::format("{:.5g} to {:.5g}", d.mean_95.low, d.mean_95.high);
    out += fmt::format("{:<28} {:>5} {:>11.5g} {:>25} {:>11.5g} {:>11.5g} {:>11.5g} {:>11.5g}\n",
                       measure, d.count, d.mean, interval, d.min, d.median, d.p95, d.max);
  }
  for (const SweepRun& run : sweep.runs) {
    if (run.failure) {
      out += fmt::format("seed {}: {}\n", run.seed, *run.failure);
    } else if (!run.as_expected) {
      out += fmt::format("seed {}: not as expected; {}\n", run.seed, run.ended);
    }
  }
  return out;
}

}  // namespace aprsim::client
