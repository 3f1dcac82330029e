#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "aprsim/v1/journal.pb.h"
#include "server/journal/recorded_scenes.hpp"
#include "server/replay/difference.hpp"
#include "world/base/result.hpp"
#include "world/cell/world.hpp"
#include "world/runtime/record/recorder.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server::journal {

struct ReplayResult {
  std::uint64_t steps = 0, commands = 0;
  std::uint64_t compared = 0;  ///< states and checkpoints
  std::uint64_t gaps =
      0;  ///< gaps with missing commands; the replay continues at the next checkpoint
  std::uint64_t missing = 0;             ///< missing records in all gaps
  std::optional<Difference> difference;  ///< the first one, which ends the replay
  std::uint64_t replies = 0;             ///< compared replies of listeners, see WireCheck
  std::optional<Difference> reply;       ///< the first reply that differs
  std::string damage;                    ///< why the journal ends early; empty = complete

  [[nodiscard]] bool same() const { return !difference && !reply; }
};

/// Replays the commands of a journal in a world without threads or clocks. Thread: one at a time.
class Replay {
 public:
  /// `header` of the journal; `scene`: see scene_of(); `directory`: as in RecordedScenes. Throws
  /// std::runtime_error as World does.
  Replay(const v1::JournalHeader& header, std::shared_ptr<const scene::Scene> scene,
         std::string directory = {});

  /// Called with the world after each checkpoint, step and command; false ends the replay.
  using Watch = std::function<bool(const world::World&, world::RunTime)>;
  void watch(Watch watch) { watch_ = std::move(watch); }
  /// Ends the replay at this time.
  void end_at(world::RunTime time) { end_ = time; }

  /// Processes the next record of the journal. False after a difference, or at the end. Errors:
  /// kInvalidArgument for an impossible record: a step before the last one, a state of another
  /// layout.
  [[nodiscard]] Result<bool> process(const v1::JournalRecord& record);
  /// After the last record: continues to the last step that any record names, without a state to
  /// compare.
  [[nodiscard]] Result<void> finish();
  [[nodiscard]] const ReplayResult& result() const { return result_; }
  [[nodiscard]] const world::World& world() const { return *world_; }

 private:
  [[nodiscard]] Result<void> advance(const v1::JournalTime& time);
  [[nodiscard]] Result<void> begin(const v1::JournalEpoch& epoch);
  [[nodiscard]] Result<void> command(const v1::JournalCommand& command);
  [[nodiscard]] Result<void> compare(const v1::JournalState& state);
  [[nodiscard]] Result<void> compare(const v1::JournalCheckpoint& checkpoint);
  [[nodiscard]] Result<void> checkpoint(const v1::JournalCheckpoint& checkpoint);
  void build(const std::shared_ptr<const scene::Scene>& scene, std::uint64_t seed);
  void extend_to(world::RunTime time);
  void differs(const std::string& what);
  void notify_watch();

  RecordedScenes scenes_;
  std::uint32_t state_version_;
  std::unique_ptr<world::World> world_;
  std::uint64_t epoch_ = 0;
  world::RunTime last_reported_;  ///< the latest time of wire records and events
  bool lost_ = true;              ///< the state is unknown until the next epoch or checkpoint
  bool stopped_ = false;          ///< the recorded simulation has stopped
  bool over_ = false;
  Watch watch_;
  std::optional<world::RunTime> end_;
  ReplayResult result_;
};

/// Reads the scene of a journal's header. Writes its models to files in `directory`, which must
/// exist. Errors: kInvalidArgument with the invalid field.
[[nodiscard]] Result<scene::Scene> scene_of(const v1::JournalHeader& header,
                                            const std::string& directory);

/// Differences between this program and the recording one, a sentence each; with any, bits may
/// differ.
[[nodiscard]] std::vector<std::string> cautions(const v1::JournalHeader& header,
                                                const v1::JournalHeader& here);

}  // namespace aprsim::server::journal
