#include "clients/aprsim/batch/batch_report.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/batch/batch_results.hpp"
#include "clients/aprsim/batch/seeds.hpp"
#include "clients/aprsim/scenario/measure_text.hpp"
#include "clients/aprsim/scenario/plot_frame.hpp"
#include "clients/aprsim/scenario/report_page.hpp"
#include "world/scenario/measure_kinds.hpp"

namespace aprsim::client {
namespace {

using ReportJson = nlohmann::ordered_json;

constexpr std::size_t kWorstShown = 10;
constexpr std::size_t kShownParameters = 12, kShownSensitivities = 20;
constexpr std::size_t kLeastForHistogram = 5;  // runs
constexpr std::size_t kColumns = 24;           // of a histogram, at most

struct MeasureSummary {
  std::string name;
  Distribution values;
};

struct Totals {
  std::size_t runs = 0, as_expected = 0;
  std::vector<std::uint64_t> missing;
  std::vector<MeasureSummary> measures;  ///< in the order of scenario::measure_kinds()
};

Totals totals_of(const Batch& batch) {
  Totals out{.runs = batch.episodes.size()};
  for (const auto& [seed, episode] : batch.episodes) out.as_expected += episode.as_expected;
  for (const std::uint64_t seed : batch.seeds) {
    if (!batch.episodes.contains(seed)) out.missing.push_back(seed);
  }
  for (const auto& kind : scenario::measure_kinds()) {
    const std::string name(kind.name);
    auto values = values_of(batch, name);
    if (!values.empty()) out.measures.push_back({name, distribution_of(std::move(values))});
  }
  return out;
}

ReportJson json_of(const Interval& interval) {
  return ReportJson::array({interval.low, interval.high});
}

ReportJson json_of(const MeasureSummary& measure) {
  const Distribution& d = measure.values;
  const auto* kind = scenario::find_measure(measure.name);
  return {{"unit", kind == nullptr ? "1" : std::string(kind->unit)},
          {"better", better_text(measure.name)},
          {"runs", d.count},
          {"mean", d.mean},
          {"mean_95", json_of(d.mean_95)},
          {"deviation", d.deviation},
          {"min", d.min},
          {"p05", d.p05},
          {"median", d.median},
          {"p95", d.p95},
          {"max", d.max}};
}

std::string head_line(const Batch& batch, const Totals& totals) {
  std::string out = fmt::format("{}: {} run{}, {} as expected", batch.identity.scenario,
                                totals.runs, totals.runs == 1 ? "" : "s", totals.as_expected);
  if (totals.runs > 0) {
    const Interval interval = share_95(totals.as_expected, totals.runs);
    out += fmt::format(
        "; success rate {:.1f} %, 95 % confidence interval (Wilson) {:.1f} to {:.1f} %",
        100 * static_cast<double>(totals.as_expected) / static_cast<double>(totals.runs),
        100 * interval.low, 100 * interval.high);
  }
  if (!totals.missing.empty()) {
    out += fmt::format("; {} not run: {}", totals.missing.size(), seeds_text(totals.missing));
  }
  return out;
}

/// The parameters of the strongest correlations first.
std::vector<SuccessByParameter> most_telling(const Batch& batch,
                                             const std::vector<Sensitivity>& sensitivities) {
  auto all = success_by_parameter(batch);
  std::map<std::string, std::size_t> place;
  for (const Sensitivity& s : sensitivities) place.emplace(s.parameter, place.size());
  std::ranges::stable_sort(all, {}, [&](const SuccessByParameter& one) {
    const auto found = place.find(one.parameter);
    return found == place.end() ? place.size() : found->second;
  });
  if (all.size() > kShownParameters) all.resize(kShownParameters);
  return all;
}

std::string parameter_plot(const SuccessByParameter& one) {
  PlotFrame frame(200, PlotFrame::Axis{one.bins.front().from, one.bins.back().to, one.parameter},
                  PlotFrame::Axis{0, 100, "as expected [%]"});
  for (const SuccessBin& bin : one.bins) {
    const double share =
        100.0 * static_cast<double>(bin.as_expected) / static_cast<double>(bin.runs);
    frame.bar((bin.from + bin.to) / 2, share, 100 * bin.share_95.low, 100 * bin.share_95.high,
              fmt::format("{:.4g} to {:.4g}: {} of {} runs", bin.from, bin.to, bin.as_expected,
                          bin.runs));
  }
  return frame.text();
}

/// Columns of a histogram: one for each count, else kColumns between min and max.
struct Columns {
  double from = 0, width = 1;
  std::vector<double> counts;
};

Columns columns_of(const std::vector<double>& values, const Distribution& d) {
  const bool are_counts =
      std::ranges::all_of(values, [](double value) { return value == std::floor(value); }) &&
      d.max - d.min < kColumns;
  Columns out;
  if (are_counts) {
    out.from = d.min - 0.5;
    out.counts.resize(static_cast<std::size_t>(d.max - d.min) + 1);
  } else {
    out.from = d.min;
    out.width = (d.max - d.min) / kColumns;
    out.counts.resize(kColumns);
  }
  for (const double value : values) {
    const auto column = static_cast<std::size_t>((value - out.from) / out.width);
    out.counts[std::min(column, out.counts.size() - 1)] += 1;
  }
  return out;
}

std::string histogram(const Batch& batch, const MeasureSummary& measure) {
  const Distribution& d = measure.values;
  const Columns columns = columns_of(values_of(batch, measure.name), d);
  const double end = columns.from + columns.width * static_cast<double>(columns.counts.size());
  const std::string better = better_text(measure.name);
  PlotFrame frame(160,
                  PlotFrame::Axis{columns.from, end,
                                  measure_title(measure.name) + ", " + better + " is better"},
                  PlotFrame::Axis{0, *std::ranges::max_element(columns.counts), "runs"});
  for (std::size_t i = 0; i < columns.counts.size(); ++i) {
    if (columns.counts[i] == 0) continue;
    const double from = columns.from + columns.width * static_cast<double>(i);
    frame.band(
        from, from + columns.width, 0, columns.counts[i], PlotFrame::kBlue, 0.7,
        fmt::format("{:.4g} to {:.4g}: {} runs", from, from + columns.width, columns.counts[i]));
  }
  frame.line(d.median, "#1d2630", "median " + measure_value_alone(measure.name, d.median));
  return frame.text();
}

/// Histograms of the measures that vary and have a better side, given enough runs.
std::string histograms(const Batch& batch, const Totals& totals) {
  std::string out;
  for (const MeasureSummary& measure : totals.measures) {
    const Distribution& d = measure.values;
    if (d.count < kLeastForHistogram || d.min == d.max || better_side(measure.name) == 0) continue;
    out += histogram(batch, measure);
  }
  return out;
}

std::string interval_text(const Interval& interval) {
  return fmt::format("{:.5g} to {:.5g}", interval.low, interval.high);
}

/// Journals of runs that are not among the worst ones.
std::vector<std::uint64_t> other_journals(const Batch& batch, const std::vector<WorstRun>& worst) {
  std::vector<std::uint64_t> out;
  for (const std::uint64_t seed : batch.journals) {
    if (std::ranges::find(worst, seed, &WorstRun::seed) == worst.end()) out.push_back(seed);
  }
  return out;
}

std::string measures_text(const Totals& totals) {
  if (totals.measures.empty()) return "";
  std::string out =
      fmt::format("\n{:<28} {:>6} {:>5} {:>11} {:>25} {:>11} {:>11} {:>11} {:>11}\n", "measure",
                  "better", "runs", "mean", "95 % interval of mean", "min", "median", "p95", "max");
  for (const auto& [name, d] : totals.measures) {
    out +=
        fmt::format("{:<28} {:>6} {:>5} {:>11.5g} {:>25} {:>11.5g} {:>11.5g} {:>11.5g} {:>11.5g}\n",
                    measure_title(name), better_text(name), d.count, d.mean,
                    interval_text(d.mean_95), d.min, d.median, d.p95, d.max);
  }
  return out;
}

std::string correlations_text(const std::vector<Sensitivity>& sensitivities) {
  if (sensitivities.empty()) return "";
  std::string out = fmt::format("\n{:<36} {:<24} {:>11} {:>10} {:>10}\n", "parameter", "outcome",
                                "correlation", "p", "adjusted p");
  for (std::size_t i = 0; i < std::min(sensitivities.size(), kShownSensitivities); ++i) {
    const Sensitivity& s = sensitivities[i];
    out += fmt::format("{:<36} {:<24} {:>11.3f} {:>10.2g} {:>10.2g}\n", s.parameter, s.outcome,
                       s.rank_correlation, s.p, s.p_adjusted);
  }
  return out;
}

std::string worst_text(const Batch& batch) {
  const auto worst = worst_runs(batch, kWorstShown);
  std::string out = worst.empty() ? "" : "\nworst runs:\n";
  for (const WorstRun& run : worst) {
    out += fmt::format("seed {}: {}{}\n", run.seed, run.why,
                       run.journal ? "; " + journal_name(run.seed) : "");
  }
  const auto others = other_journals(batch, worst);
  if (!others.empty()) out += "\njournals of other runs:\n";
  for (const std::uint64_t seed : others) {
    out += fmt::format("seed {}: {}\n", seed, journal_name(seed));
  }
  return out;
}

std::string journal_link(std::uint64_t seed) {
  return fmt::format("<a href=\"{0}\">{0}</a>", journal_name(seed));
}

std::string worst_section(const Batch& batch) {
  const auto worst = worst_runs(batch, kWorstShown);
  std::string rows, other_rows;
  for (const WorstRun& run : worst) {
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n", run.seed,
                        escaped_html(run.why), run.journal ? journal_link(run.seed) : "");
  }
  for (const std::uint64_t seed : other_journals(batch, worst)) {
    other_rows += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", seed, journal_link(seed));
  }
  return page_section("Worst runs", page_table({"seed", "why", "journal"}, rows)) +
         page_section("Journals of other runs", page_table({"seed", "journal"}, other_rows));
}

std::string correlations_section(const std::vector<Sensitivity>& sensitivities) {
  std::string rows;
  for (std::size_t i = 0; i < std::min(sensitivities.size(), kShownSensitivities); ++i) {
    const Sensitivity& s = sensitivities[i];
    rows += page_row({s.parameter, s.outcome, fmt::format("{:.3f}", s.rank_correlation),
                      fmt::format("{:.2g}", s.p), fmt::format("{:.2g}", s.p_adjusted)});
  }
  if (rows.empty()) return "";
  return page_section(
      "Correlations",
      "<p>Spearman's rank correlation of each varied parameter with each outcome. The adjusted p "
      "controls the false discovery rate (Benjamini and Hochberg).</p>\n" +
          page_table({"parameter", "outcome", "correlation", "p", "adjusted p"}, rows));
}

std::string measures_section(const Batch& batch, const Totals& totals) {
  std::string rows;
  for (const auto& [name, d] : totals.measures) {
    const auto* kind = scenario::find_measure(name);
    rows += page_row({name, measure_unit(name), better_text(name), std::to_string(d.count),
                      figure_text(d.mean), interval_text(d.mean_95), figure_text(d.min),
                      figure_text(d.median), figure_text(d.p95), figure_text(d.max),
                      kind == nullptr ? "" : std::string(kind->meaning)});
  }
  return page_section("Measures", page_table({"measure", "unit", "better", "runs", "mean",
                                              "95 % confidence interval of the mean", "min",
                                              "median", "95th percentile", "max", "meaning"},
                                             rows)) +
         page_section("Distributions", histograms(batch, totals));
}

}  // namespace

ReportJson batch_json(const Batch& batch) {
  const Totals totals = totals_of(batch);
  const BatchIdentity& identity = batch.identity;
  ReportJson out{{"scenario", identity.scenario},       {"description", identity.description},
                 {"controller", identity.controller},   {"version", identity.version},
                 {"fingerprint", identity.fingerprint}, {"runs", totals.runs},
                 {"missing", totals.missing},           {"as_expected", totals.as_expected}};
  if (totals.runs > 0) {
    out["as_expected_share_95"] = json_of(share_95(totals.as_expected, totals.runs));
  }
  out["measures"] = ReportJson::object();
  for (const MeasureSummary& one : totals.measures) out["measures"][one.name] = json_of(one);
  out["success_by_parameter"] = ReportJson::object();
  for (const SuccessByParameter& one : success_by_parameter(batch)) {
    ReportJson bins = ReportJson::array();
    for (const SuccessBin& bin : one.bins) {
      bins.push_back({{"from", bin.from},
                      {"to", bin.to},
                      {"runs", bin.runs},
                      {"as_expected", bin.as_expected},
                      {"share_95", json_of(bin.share_95)}});
    }
    out["success_by_parameter"][one.parameter] = std::move(bins);
  }
  out["sensitivity"] = ReportJson::array();
  for (const Sensitivity& s : sensitivity_of(batch)) {
    out["sensitivity"].push_back({{"parameter", s.parameter},
                                  {"outcome", s.outcome},
                                  {"rank_correlation", s.rank_correlation},
                                  {"p", s.p},
                                  {"p_adjusted", s.p_adjusted}});
  }
  out["worst"] = ReportJson::array();
  for (const WorstRun& worst : worst_runs(batch, kWorstShown)) {
    ReportJson one{{"seed", worst.seed}, {"why", worst.why}};
    if (worst.journal) one["journal"] = journal_name(worst.seed);
    out["worst"].push_back(std::move(one));
  }
  out["journals"] = ReportJson::array();
  for (const std::uint64_t seed : batch.journals) {
    out["journals"].push_back({{"seed", seed}, {"journal", journal_name(seed)}});
  }
  out["episodes"] = ReportJson::array();
  for (const auto& [seed, episode] : batch.episodes)
    out["episodes"].push_back(episode_json(episode));
  return out;
}

std::string batch_table(const Batch& batch) {
  const Totals totals = totals_of(batch);
  return head_line(batch, totals) + '\n' + measures_text(totals) +
         correlations_text(sensitivity_of(batch)) + worst_text(batch);
}

std::string batch_page(const Batch& batch) {
  const Totals totals = totals_of(batch);
  const BatchIdentity& identity = batch.identity;
  const auto sensitivities = sensitivity_of(batch);
  std::string by_parameter;
  for (const SuccessByParameter& one : most_telling(batch, sensitivities)) {
    by_parameter += parameter_plot(one);
  }
  return page_head(identity.scenario) +
         fmt::format(
             "<h1>{}</h1>\n<p>{}. Controller <code>{}</code>, aprsim {}.</p>\n<p "
             "class=\"{}\">{}.</p>\n",
             escaped_html(identity.scenario), escaped_html(identity.description),
             escaped_html(identity.controller), escaped_html(identity.version),
             totals.as_expected == totals.runs ? "good" : "bad",
             escaped_html(head_line(batch, totals))) +
         worst_section(batch) + page_section("Success by parameter", by_parameter) +
         correlations_section(sensitivities) + measures_section(batch, totals) + "</body></html>\n";
}

Outcome<void> write_report(const Batch& batch, const BatchDirectory& directory) {
  const auto replace = ReportJson::error_handler_t::replace;
  for (const auto& [name, text] :
       {std::pair<const char*, std::string>("report.json",
                                            batch_json(batch).dump(1, ' ', false, replace) + '\n'),
        std::pair<const char*, std::string>("report.txt", batch_table(batch)),
        std::pair<const char*, std::string>("report.html", batch_page(batch))}) {
    if (auto done = directory.write(name, text); !done) return done;
  }
  return {};
}

}  // namespace aprsim::client
