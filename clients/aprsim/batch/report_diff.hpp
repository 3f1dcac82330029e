#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/batch/episode.hpp"
#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// The compared part of a report.
struct ComparedReport {
  std::string scenario, controller, fingerprint;
  std::vector<Episode> episodes;  ///< by rising seed
};

/// Reads report.json, given the file or its directory. Failure: kUsage.
[[nodiscard]] Outcome<ComparedReport> read_report(const std::string& path);

enum class Change { kNone, kBetter, kWorse, kOther };

/// One outcome in both reports.
struct OutcomeDifference {
  std::string outcome;            ///< "as_expected", or a measure
  double before = 0, after = 0;   ///< means; the success rate for as_expected
  double p = 1, p_adjusted = 1;   ///< adjusted for the family-wise error rate
  Change change = Change::kNone;  ///< direction of a significant change
};

struct ReportDifference {
  bool paired = false;    ///< the same seeds of the same scenario are compared run by run
  std::size_t pairs = 0;  ///< number of pairs
  std::size_t before = 0, after = 0;  ///< runs
  double alpha = 0.05;
  std::vector<OutcomeDifference> outcomes;

  [[nodiscard]] bool is_regression() const;
};

/// Compares success and every common measure with a significance test: McNemar's and Wilcoxon's
/// signed-rank test for pairs, else Fisher's and Mann and Whitney's.
[[nodiscard]] ReportDifference compare(const ComparedReport& before, const ComparedReport& after,
                                       double alpha);
[[nodiscard]] std::string difference_table(const ReportDifference& difference);
[[nodiscard]] nlohmann::ordered_json difference_json(const ReportDifference& difference);

}  // namespace aprsim::client
