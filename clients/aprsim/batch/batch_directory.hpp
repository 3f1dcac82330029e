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

/// What a batch is of: only batches of the same are put together.
struct BatchIdentity {
  std::string scenario, description, controller, version;
  std::string fingerprint;  ///< of the scenario's file and its scene
  bool operator==(const BatchIdentity&) const = default;
};

/// A batch as far as it has come.
struct Batch {
  BatchIdentity identity;
  std::vector<std::uint64_t> seeds;  ///< wanted, rising
  std::map<std::uint64_t, Episode> episodes;
  std::vector<std::uint64_t> journals;  ///< seeds of which there is one, rising
};

/// Tries that gave no episode. They are no part of the results.
struct Attempts {
  std::uint64_t again = 0;                                         ///< runs that were tried again
  std::vector<std::pair<std::uint64_t, std::string>> last_causes;  ///< by seed; the latest 100
  std::uint64_t peak_world_bytes = 0;                              ///< of any daemon
};

/// The directory of a batch: `batch.json` (what it is of, and the seeds), `episodes/seed_N.json`
/// for each that is done, `journals/seed_N.journal`, `attempts.json`, and the report. Each file is
/// written whole under another name first, so it is there whole or not at all, whatever is killed.
/// Thread: one at a time.
class BatchDirectory {
 public:
  explicit BatchDirectory(std::filesystem::path path) : path_(std::move(path)) {}

  /// Begins a batch, or goes on with one: the seeds are added to those that it has. Failures:
  /// kUsage for a batch of something else, or a directory that cannot be written.
  [[nodiscard]] Outcome<Batch> begin(const BatchIdentity& identity,
                                     const std::vector<std::uint64_t>& seeds);
  /// Failures: kUsage when it is no batch or a file is damaged.
  [[nodiscard]] Outcome<Batch> read() const;

  [[nodiscard]] Outcome<void> keep(const Episode& episode);
  [[nodiscard]] Outcome<void> keep(const Attempts& attempts);
  [[nodiscard]] Outcome<void> write(const std::string& name, const std::string& text) const;

  [[nodiscard]] std::string journal(std::uint64_t seed) const;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Name of a seed's journal in the directory of its batch.
[[nodiscard]] std::string journal_name(std::uint64_t seed);

/// Batches of the same as one. Failures: kUsage for batches of different things, and for a seed
/// with different results.
[[nodiscard]] Outcome<Batch> merge(const std::vector<Batch>& batches,
                                   const std::vector<std::string>& names);

}  // namespace aprsim::client
