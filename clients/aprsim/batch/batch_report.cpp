#include "clients/aprsim/batch/batch_report.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/batch/seeds.hpp"
#include "clients/aprsim/batch/significance.hpp"
#include "clients/aprsim/scenario/plot_frame.hpp"
#include "clients/aprsim/scenario/report_page.hpp"
#include "world/scenario/measure_kinds.hpp"

namespace aprsim::client {
namespace {

using ReportJson = nlohmann::ordered_json;

constexpr std::size_t kBins = 5;
constexpr std::size_t kLeastForBins = 10, kLeastForSensitivity = 10;  // episodes
constexpr std::size_t kShownParameters = 12, kShownSensitivities = 20;

struct Totals {
  std::size_t runs = 0, as_expected = 0;
  std::vector<std::uint64_t> missing;
  std::map<std::string, Distribution> measures;
};

Totals totals_of(const Batch& batch) {
  Totals out{.runs = batch.episodes.size()};
  std::map<std::string, std::vector<double>> values;
  for (const auto& [seed, episode] : batch.episodes) {
    if (episode.as_expected) ++out.as_expected;
    for (const auto& [measure, value] : episode.values) values[measure].push_back(value);
  }
  for (const std::uint64_t seed : batch.seeds) {
    if (!batch.episodes.contains(seed)) out.missing.push_back(seed);
  }
  for (auto& [measure, all] : values) out.measures[measure] = distribution_of(std::move(all));
  return out;
}

/// The values of each parameter beside those of the episodes that have it.
std::map<std::string, std::vector<std::pair<double, const Episode*>>> by_parameter(
    const Batch& batch) {
  std::map<std::string, std::vector<std::pair<double, const Episode*>>> out;
  for (const auto& [seed, episode] : batch.episodes) {
    for (const auto& [parameter, value] : episode.drawn) {
      out[parameter].emplace_back(value, &episode);
    }
  }
  for (auto& [parameter, pairs] : out) {
    std::ranges::stable_sort(pairs, {}, [](const auto& pair) { return pair.first; });
  }
  return out;
}

/// What an episode is measured by: success, the measures with a better side, and the time.
std::set<std::string> outcomes_of(const Batch& batch) {
  std::set<std::string> out{kAsExpected};
  for (const auto& [seed, episode] : batch.episodes) {
    for (const auto& [measure, value] : episode.values) {
      const auto* kind = scenario::find_measure(measure);
      if (measure == "run_s" || (kind != nullptr && kind->better != 0)) out.insert(measure);
    }
  }
  return out;
}

std::optional<double> outcome_of(const Episode& episode, const std::string& outcome) {
  if (outcome == kAsExpected) return episode.as_expected ? 1 : 0;
  const auto found = episode.values.find(outcome);
  return found == episode.values.end() ? std::nullopt : std::optional(found->second);
}

double value_or(const Episode& episode, const char* measure, double other) {
  const auto found = episode.values.find(measure);
  return found == episode.values.end() ? other : found->second;
}

ReportJson json_of(const Interval& interval) {
  return ReportJson::array({interval.low, interval.high});
}

ReportJson json_of(const Distribution& d) {
  return {{"runs", d.count},          {"mean", d.mean}, {"mean_95", json_of(d.mean_95)},
          {"deviation", d.deviation}, {"min", d.min},   {"p05", d.p05},
          {"median", d.median},       {"p95", d.p95},   {"max", d.max}};
}

std::string percent(const Interval& share) {
  return fmt::format("{:.1f} to {:.1f} %", 100 * share.low, 100 * share.high);
}

std::string head_line(const Batch& batch, const Totals& totals) {
  std::string out = fmt::format("{}: {} runs, {} as expected", batch.identity.scenario, totals.runs,
                                totals.as_expected);
  if (totals.runs > 0) {
    out += fmt::format(" (95 % of such batches: {})",
                       percent(share_95(totals.as_expected, totals.runs)));
  }
  if (!totals.missing.empty()) {
    out += fmt::format("; {} not run: {}", totals.missing.size(), seeds_text(totals.missing));
  }
  return out;
}

/// Those that have most to do with success, as far as that can be told.
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
    frame.bar(
        (bin.from + bin.to) / 2, share, 100 * bin.share_95.low, 100 * bin.share_95.high,
        fmt::format("{:.4g} to {:.4g}: {} of {}", bin.from, bin.to, bin.as_expected, bin.runs));
  }
  return frame.text();
}

std::string histogram(const Batch& batch, const std::string& measure, const Distribution& d) {
  constexpr std::size_t kColumns = 24;
  std::vector<double> counts(kColumns);
  const double width = (d.max - d.min) / kColumns;
  for (const auto& [seed, episode] : batch.episodes) {
    const auto value = outcome_of(episode, measure);
    if (!value) continue;
    const auto column = static_cast<std::size_t>((*value - d.min) / width);
    counts[std::min(column, kColumns - 1)] += 1;
  }
  const auto* kind = scenario::find_measure(measure);
  const std::string unit =
      kind == nullptr || kind->unit == "1" ? "" : fmt::format(" [{}]", kind->unit);
  PlotFrame frame(160, PlotFrame::Axis{d.min, d.max, measure + unit},
                  PlotFrame::Axis{0, *std::ranges::max_element(counts), "runs"});
  for (std::size_t i = 0; i < kColumns; ++i) {
    const double from = d.min + width * static_cast<double>(i);
    if (counts[i] > 0) {
      frame.band(from, from + width, 0, counts[i], PlotFrame::kBlue, 0.7,
                 fmt::format("{:.4g} to {:.4g}: {}", from, from + width, counts[i]));
    }
  }
  return frame.text();
}

}  // namespace

std::vector<SuccessByParameter> success_by_parameter(const Batch& batch) {
  std::vector<SuccessByParameter> out;
  for (const auto& [parameter, pairs] : by_parameter(batch)) {
    if (pairs.size() < kLeastForBins) continue;
    SuccessByParameter one{.parameter = parameter};
    for (std::size_t i = 0; i < kBins; ++i) {
      const std::size_t begin = pairs.size() * i / kBins, end = pairs.size() * (i + 1) / kBins;
      SuccessBin bin{.from = pairs[begin].first, .to = pairs[end - 1].first, .runs = end - begin};
      for (std::size_t k = begin; k < end; ++k) bin.as_expected += pairs[k].second->as_expected;
      bin.share_95 = share_95(bin.as_expected, bin.runs);
      one.bins.push_back(bin);
    }
    out.push_back(std::move(one));
  }
  return out;
}

std::vector<Sensitivity> sensitivity_of(const Batch& batch) {
  std::vector<Sensitivity> out;
  const auto outcomes = outcomes_of(batch);
  for (const auto& [parameter, pairs] : by_parameter(batch)) {
    for (const std::string& outcome : outcomes) {
      std::vector<double> x, y;
      for (const auto& [value, episode] : pairs) {
        if (const auto result = outcome_of(*episode, outcome)) {
          x.push_back(value);
          y.push_back(*result);
        }
      }
      if (x.size() < kLeastForSensitivity || std::ranges::min(y) == std::ranges::max(y)) continue;
      const Correlation correlation = rank_correlation(x, y);
      out.push_back({parameter, outcome, correlation.rho, correlation.p});
    }
  }
  std::vector<double> p;
  for (const Sensitivity& s : out) p.push_back(s.p);
  const auto adjusted = by_false_discovery(p);
  for (std::size_t i = 0; i < out.size(); ++i) out[i].p_adjusted = adjusted[i];
  std::ranges::stable_sort(out, {}, &Sensitivity::p);
  return out;
}

std::vector<WorstEpisode> worst_of(const Batch& batch, std::size_t most) {
  std::vector<const Episode*> all;
  for (const auto& [seed, episode] : batch.episodes) all.push_back(&episode);
  std::ranges::stable_sort(all, {}, [](const Episode* episode) {
    return std::tuple(episode->as_expected, -static_cast<double>(episode->broken.size()),
                      value_or(*episode, "score_share", 0), -value_or(*episode, "run_s", 0));
  });
  all.resize(std::min(all.size(), most));
  std::vector<WorstEpisode> out;
  for (const Episode* episode : all) {
    WorstEpisode worst{.seed = episode->seed};
    for (const std::string& bound : episode->broken) {
      worst.why += (worst.why.empty() ? "" : "; ") + bound;
    }
    worst.why += (worst.why.empty() ? "as expected; " : "; ") + episode->ended;
    worst.journal = std::ranges::binary_search(batch.journals, episode->seed);
    out.push_back(std::move(worst));
  }
  return out;
}

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
  for (const auto& [measure, all] : totals.measures) out["measures"][measure] = json_of(all);
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
  for (const WorstEpisode& worst : worst_of(batch, kWorstShown)) {
    ReportJson one{{"seed", worst.seed}, {"why", worst.why}};
    if (worst.journal) one["journal"] = journal_name(worst.seed);
    out["worst"].push_back(std::move(one));
  }
  out["each"] = ReportJson::array();
  for (const auto& [seed, episode] : batch.episodes) out["each"].push_back(episode_json(episode));
  return out;
}

std::string batch_table(const Batch& batch) {
  const Totals totals = totals_of(batch);
  std::string out = head_line(batch, totals);
  out += fmt::format("\n\n{:<28} {:>5} {:>11} {:>25} {:>11} {:>11} {:>11} {:>11}\n", "measure",
                     "runs", "mean", "95 % interval of it", "min", "median", "p95", "max");
  for (const auto& [measure, d] : totals.measures) {
    const std::string interval = fmt::format("{:.5g} to {:.5g}", d.mean_95.low, d.mean_95.high);
    out += fmt::format("{:<28} {:>5} {:>11.5g} {:>25} {:>11.5g} {:>11.5g} {:>11.5g} {:>11.5g}\n",
                       measure, d.count, d.mean, interval, d.min, d.median, d.p95, d.max);
  }
  const auto sensitivities = sensitivity_of(batch);
  if (!sensitivities.empty()) {
    out += fmt::format("\n{:<36} {:<24} {:>11} {:>10} {:>10}\n", "what varied", "goes with",
                       "correlation", "p", "adjusted");
    for (std::size_t i = 0; i < std::min(sensitivities.size(), kShownSensitivities); ++i) {
      const Sensitivity& s = sensitivities[i];
      out += fmt::format("{:<36} {:<24} {:>11.3f} {:>10.2g} {:>10.2g}\n", s.parameter, s.outcome,
                         s.rank_correlation, s.p, s.p_adjusted);
    }
  }
  const auto worst = worst_of(batch, kWorstShown);
  if (!worst.empty()) out += "\nthe worst:\n";
  for (const WorstEpisode& one : worst) {
    out += fmt::format("seed {}: {}{}\n", one.seed, one.why,
                       one.journal ? "; " + journal_name(one.seed) : "");
  }
  return out;
}

std::string batch_page(const Batch& batch) {
  const Totals totals = totals_of(batch);
  const auto sensitivities = sensitivity_of(batch);
  std::string out =
      page_head(batch.identity.scenario) +
      fmt::format(
          "<h1>{}</h1>\n<p>{}. Controller <code>{}</code>, aprsim {}.</p>\n<p "
          "class=\"{}\">{}.</p>\n",
          escaped_html(batch.identity.scenario), escaped_html(batch.identity.description),
          escaped_html(batch.identity.controller), escaped_html(batch.identity.version),
          totals.as_expected == totals.runs ? "good" : "bad",
          escaped_html(head_line(batch, totals)));
  out += "<h2>The worst</h2>\n<table>" + page_row({"seed", "why", "journal"}, "th");
  for (const WorstEpisode& worst : worst_of(batch, kWorstShown)) {
    const std::string name = journal_name(worst.seed);
    out += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n", worst.seed,
                       escaped_html(worst.why),
                       worst.journal ? fmt::format("<a href=\"{0}\">{0}</a>", name) : "");
  }
  out += "</table>\n<h2>Success against what varied</h2>\n";
  for (const SuccessByParameter& one : most_telling(batch, sensitivities)) {
    out += parameter_plot(one);
  }
  out +=
      "<h2>What goes with what</h2>\n<p>Rank correlations after Spearman; p adjusted for the "
      "share of false findings.</p>\n<table>" +
      page_row({"what varied", "goes with", "correlation", "p", "adjusted"}, "th");
  for (std::size_t i = 0; i < std::min(sensitivities.size(), kShownSensitivities); ++i) {
    const Sensitivity& s = sensitivities[i];
    out += page_row({s.parameter, s.outcome, fmt::format("{:.3f}", s.rank_correlation),
                     fmt::format("{:.2g}", s.p), fmt::format("{:.2g}", s.p_adjusted)});
  }
  out += "</table>\n<h2>Measures</h2>\n<table>" +
         page_row({"measure", "runs", "mean", "95 % interval of it", "min", "median", "p95", "max"},
                  "th");
  for (const auto& [measure, d] : totals.measures) {
    out += page_row({measure, std::to_string(d.count), figure_text(d.mean),
                     fmt::format("{:.5g} to {:.5g}", d.mean_95.low, d.mean_95.high),
                     figure_text(d.min), figure_text(d.median), figure_text(d.p95),
                     figure_text(d.max)});
  }
  out += "</table>\n";
  for (const auto& [measure, d] : totals.measures) {
    const auto* kind = scenario::find_measure(measure);
    if (d.min < d.max && kind != nullptr && kind->better != 0) {
      out += histogram(batch, measure, d);
    }
  }
  return out + "</body></html>\n";
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
