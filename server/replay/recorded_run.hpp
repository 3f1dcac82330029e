#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aprsim/v1/journal.pb.h"
#include "world/base/result.hpp"
#include "world/runtime/record/recorder.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server::journal {

/// A simulated time of a run, as the user gives it.
struct RunMoment {
  std::optional<std::uint64_t> epoch;  ///< absent = the first recorded one
  double seconds = 0;
};
/// Parses "SECONDS" or "EPOCH:SECONDS". Errors: kInvalidArgument.
[[nodiscard]] Result<RunMoment> to_run_moment(const std::string& text);

/// The files of one run, with its scene. Thread: one at a time.
class RecordedRun {
 public:
  /// `places`: all files, or one place as files_of_run() has it. `version`: of this program.
  /// Errors: kInvalidArgument with the file (no journal, of another run than the first, no scene
  /// that can be read); kNotFound, kUnavailable.
  [[nodiscard]] static Result<RecordedRun> open(const std::vector<std::string>& places,
                                                const std::string& version);

  [[nodiscard]] const v1::JournalHeader& header() const { return header_; }
  [[nodiscard]] const std::shared_ptr<const scene::Scene>& scene() const { return scene_; }
  /// The directory of its robot descriptions, removed with the last copy of the run.
  [[nodiscard]] const std::string& directory() const { return *models_; }
  /// Reasons why bits may differ, a sentence each.
  [[nodiscard]] const std::vector<std::string>& cautions() const { return cautions_; }
  /// Whether this program can read its checkpoints.
  [[nodiscard]] bool has_checkpoints() const;

  /// Calls `take` for each record in order until it returns false or an error. Returns the reason
  /// why a journal ends early, empty if none does. Errors: of a file, or of `take` with the file's
  /// name.
  using Take = std::function<Result<bool>(const v1::JournalRecord&)>;
  [[nodiscard]] Result<std::string> each(const Take& take) const;

  /// Epoch and step of a moment. Errors: kInvalidArgument for an epoch that is not recorded.
  [[nodiscard]] Result<world::RunTime> time_of(const RunMoment& moment) const;
  /// Number of the record with the last checkpoint at or before a time; 0, the first record, where
  /// there is none.
  [[nodiscard]] Result<std::uint64_t> checkpoint_before(world::RunTime time) const;

 private:
  RecordedRun() = default;

  std::vector<std::string> files_;
  v1::JournalHeader header_;
  std::shared_ptr<const std::string> models_;  ///< their directory, removed with it
  std::shared_ptr<const scene::Scene> scene_;
  std::vector<std::string> cautions_;
};

/// The time of a record, if it has one.
[[nodiscard]] std::optional<world::RunTime> time_of(const v1::JournalRecord& record);

}  // namespace aprsim::server::journal
