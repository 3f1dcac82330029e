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
  std::uint64_t gaps = 0;      ///< with commands missing: gone on from the checkpoint behind them
  std::uint64_t missing = 0;   ///< records, as all gaps tell
  std::optional<Difference> difference;  ///< the first; nothing was run after it
  std::uint64_t replies = 0;             ///< of listeners that were compared, see WireCheck
  std::optional<Difference> reply;       ///< the first of them that is another one
  std::string damage;                    ///< why the journal ends early; empty = it does not

  [[nodiscard]] bool same() const { return !difference && !reply; }
};

/// Runs a journal's commands again in a world without threads or clocks. Thread: one at a time.
class Replay {
 public:
  /// `header` of the journal; `scene`: see scene_of(). Throws std::runtime_error as World does.
  Replay(const v1::JournalHeader& header, std::shared_ptr<const scene::Scene> scene);

  /// Called with the world when it was put somewhere, and after each step and command; false ends
  /// the replay there.
  using Watch = std::function<bool(const world::World&, world::RunTime)>;
  void watch(Watch watch) { watch_ = std::move(watch); }
  /// Nothing is run after this time.
  void end_at(world::RunTime time) { end_ = time; }

  /// The journal's next record. False once there is a difference, or the end. Errors:
  /// kInvalidArgument where the record cannot be: a step before the last one, a state of another
  /// layout.
  [[nodiscard]] Result<bool> take(const v1::JournalRecord& record);
  /// After the last record: goes on to the last step that any of them tells of, without a state to
  /// compare there.
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
  void tell(world::RunTime time);
  void differs(const std::string& what);
  void look();

  RecordedScenes scenes_;
  std::uint32_t state_version_;
  std::unique_ptr<world::World> world_;
  std::uint64_t epoch_ = 0;
  world::RunTime told_;   ///< the latest that wires and events tell of
  bool lost_ = true;      ///< where the run is will be known with the next epoch or checkpoint
  bool stopped_ = false;  ///< the recorded world has
  bool over_ = false;
  Watch watch_;
  std::optional<world::RunTime> end_;
  ReplayResult result_;
};

/// The scene that a journal has in its header. The models go to files in
/// `directory`, which has to be there. Errors: kInvalidArgument naming what does not fit.
[[nodiscard]] Result<scene::Scene> scene_of(const v1::JournalHeader& header,
                                            const std::string& directory);

/// Differences of this program from the journal's, a sentence each: then bits may differ.
[[nodiscard]] std::vector<std::string> cautions(const v1::JournalHeader& header,
                                                const v1::JournalHeader& here);

}  // namespace aprsim::server::journal
