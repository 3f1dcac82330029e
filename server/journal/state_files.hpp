#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "aprsim/v1/journal.pb.h"
#include "protocols/ports/state_files.hpp"
#include "world/cell/world.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server::journal {

/// Saved states as journals of one state: the scene with its models and digests, an epoch that
/// begins with the state's name, and the state as its checkpoint, with what was changed of the
/// scene. Checks it against a world of its own, which it builds when it is needed.
class SceneStateFiles final : public protocols::StateFiles {
 public:
  using FindScene = std::function<std::shared_ptr<const scene::Scene>()>;
  /// `scene` gives that of the cell as it was loaded last, in any thread; `version`: of this
  /// program.
  SceneStateFiles(FindScene scene, std::string version)
      : scene_(std::move(scene)), version_(std::move(version)) {}

  [[nodiscard]] Result<std::string> write(const std::string& name,
                                          const api::StatePtr& state) override;
  [[nodiscard]] Result<Read> read(std::string bytes) override;

 private:
  [[nodiscard]] Result<v1::JournalHeader> header(const scene::Scene& scene) const;
  [[nodiscard]] std::uint64_t hash_of(const world::WorldState& state);

  const FindScene scene_;
  const std::string version_;
  std::mutex mutex_;                     ///< of what is below
  std::unique_ptr<world::World> world_;  ///< of the scene of the last state
};

}  // namespace aprsim::server::journal
