#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "aprsim/v1/journal.pb.h"
#include "protocols/state_files.hpp"
#include "world/scene/scene.hpp"
#include "world/world.hpp"

namespace aprsim::server::journal {

/// Saved states as journals of one state: the scene with its models and digests, an epoch that
/// begins with the state's name, and the state as its checkpoint. Checks it against a world of its
/// own, which it builds when it is first needed.
class SceneStateFiles final : public protocols::StateFiles {
 public:
  /// `version`: of this program.
  SceneStateFiles(std::shared_ptr<const scene::Scene> scene, std::string version)
      : scene_(std::move(scene)), version_(std::move(version)) {}

  [[nodiscard]] Result<std::string> write(const std::string& name,
                                          const api::StatePtr& state) override;
  [[nodiscard]] Result<Read> read(std::string bytes) override;

 private:
  [[nodiscard]] Result<void> prepare();

  const std::shared_ptr<const scene::Scene> scene_;
  const std::string version_;
  std::mutex mutex_;  ///< of all below
  v1::JournalHeader header_;
  std::unique_ptr<world::World> world_;
};

}  // namespace aprsim::server::journal
