#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/batch/episode.hpp"
#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// Identity of a batch: only batches with the same identity are merged.
struct BatchIdentity {
  std::string scenario, description, controller, version;
  std::string fingerprint;  ///< of the scenario's file and its scene
  bool operator==(const BatchIdentity&) const = default;
};

/// A batch with its finished runs.
struct Batch {
  BatchIdentity identity;
  std::vector<std::uint64_t> seeds;  ///< wanted, rising
  std::map<std::uint64_t, Episode> episodes;
  std::vector<std::uint64_t> journals;  ///< seeds of which there is one, rising
};

/// Attempts without a result. They are not part of the report.
struct Attempts {
  std::uint64_t repeated = 0;                                      ///< attempts after a failure
  std::vector<std::pair<std::uint64_t, std::string>> last_causes;  ///< by seed; the latest 100
  std::uint64_t peak_world_bytes = 0;                              ///< of any daemon
};

/// The directory of a batch: `batch.json` (identity and seeds), `episodes/seed_N.json` for each
/// finished run, `journals/seed_N.journal`, `attempts.json`, and the report. Each file is written
/// under another name and renamed, so a killed process leaves no half-written file.
/// Thread: one at a time.
class BatchDirectory {
 public:
  explicit BatchDirectory(std::filesystem::path path) : path_(std::move(path)) {}

  /// Creates the batch, or continues an existing one and adds the seeds to it. Failures: kUsage for
  /// a batch with another identity, or a directory that cannot be written.
  [[nodiscard]] Outcome<Batch> begin(const BatchIdentity& identity,
                                     const std::vector<std::uint64_t>& seeds);
  /// Reads the batch. Failures: kUsage for a directory without a batch or with a damaged file.
  [[nodiscard]] Outcome<Batch> read() const;

  [[nodiscard]] Outcome<void> keep(const Episode& episode);
  [[nodiscard]] Outcome<void> keep(const Attempts& attempts);
  [[nodiscard]] Outcome<void> write(const std::string& name, const std::string& text) const;

  [[nodiscard]] std::string journal(std::uint64_t seed) const;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// File name of a seed's journal, relative to the directory of its batch.
[[nodiscard]] std::string journal_name(std::uint64_t seed);

/// Merges batches of one identity. Failures: kUsage for different identities, and for a seed with
/// different results.
[[nodiscard]] Outcome<Batch> merge(const std::vector<Batch>& batches,
                                   const std::vector<std::string>& names);

}  // namespace aprsim::client
