#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/scenario/run_result.hpp"
#include "clients/aprsim/text/paint.hpp"
#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// The complete result as JSON; equal results give equal text.
[[nodiscard]] nlohmann::ordered_json report_json(const RunResult& run);
/// Measures, kits, faults and the verdict, for a terminal.
[[nodiscard]] std::string report_table(const RunResult& run, const Paint& paint);
/// A self-contained HTML page with plots.
[[nodiscard]] std::string report_page(const RunResult& run);

/// The files that write_report() writes into a directory.
[[nodiscard]] std::vector<std::string> report_files(const std::string& directory);
/// Writes report.json, report.txt and report.html into a directory, created if
/// absent. Failure: a file that cannot be written.
[[nodiscard]] Outcome<void> write_report(const RunResult& run, const std::string& directory);

}  // namespace aprsim::client
