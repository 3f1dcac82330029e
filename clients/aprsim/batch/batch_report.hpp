#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/batch/batch_directory.hpp"
#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// The report. Equal runs give equal text, in whatever order and by whichever shards they ran.
[[nodiscard]] nlohmann::ordered_json batch_json(const Batch& batch);
/// For a terminal.
[[nodiscard]] std::string batch_table(const Batch& batch);
/// A self-contained HTML page with plots.
[[nodiscard]] std::string batch_page(const Batch& batch);
/// Writes report.json, report.txt and report.html, each whole or not at all.
[[nodiscard]] Outcome<void> write_report(const Batch& batch, const BatchDirectory& directory);

}  // namespace aprsim::client
