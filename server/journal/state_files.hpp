#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "aprsim/v1/journal.pb.h"
#include "protocols/ports/state_files.hpp"
#include "server/journal/state_seal.hpp"
#include "world/cell/world.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server::journal {

/// Saved states as journals of one state: the scene with its models and digests, an epoch that
/// begins with the state's name, and the state as its checkpoint with the changes of its scene and
/// a signature (StateSeal). Reads the first state of such a file or of a run's journal, if it is
/// signed with the key of this user or the configuration allows others. Restores each in a world of
/// its own first. Thread: any.
class SceneStateFiles final : public protocols::StateFiles {
 public:
  using FindScene = std::function<std::shared_ptr<const scene::Scene>()>;
  /// `scene` gives that of the cell as it was loaded last, in any thread; `version`: of this
  /// program; `accepts_foreign`: whether states without a signature of this user are read.
  SceneStateFiles(FindScene scene, std::string version, bool accepts_foreign)
      : scene_(std::move(scene)), version_(std::move(version)), accepts_foreign_(accepts_foreign) {}

  [[nodiscard]] Result<std::string> write(const std::string& name,
                                          const api::StatePtr& state) override;
  [[nodiscard]] Result<Read> read(std::string bytes) override;

 private:
  [[nodiscard]] Result<v1::JournalHeader> header(const scene::Scene& scene) const;
  [[nodiscard]] const StateSeal& seal();
  [[nodiscard]] Result<Read> read_first(std::string bytes);
  [[nodiscard]] Result<void> check(const world::WorldState& state,
                                   const v1::JournalCheckpoint& checkpoint);
  /// The world of the state's scene, in that state.
  [[nodiscard]] const world::World& world_in(const world::WorldState& state);

  const FindScene scene_;
  const std::string version_;
  const bool accepts_foreign_;
  std::mutex mutex_;                     ///< guards the members below
  std::optional<StateSeal> seal_;        ///< made when it is needed
  std::unique_ptr<world::World> world_;  ///< of the scene of the last state
};

}  // namespace aprsim::server::journal
