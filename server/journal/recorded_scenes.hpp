#pragma once

#include <memory>
#include <string>

#include "aprsim/v1/journal.pb.h"
#include "world/base/result.hpp"
#include "world/cell/world.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server::journal {

/// The scenes of a run's epochs and checkpoints, and the states of these, which belong to them.
/// Thread: one at a time.
class RecordedScenes {
 public:
  using ScenePtr = std::shared_ptr<const scene::Scene>;

  /// `scene`: the header's. Throws std::runtime_error where its models cannot be read.
  explicit RecordedScenes(ScenePtr scene);

  [[nodiscard]] const ScenePtr& of_header() const { return header_; }
  [[nodiscard]] const world::ArmModels& models() const { return models_; }

  /// What the world of an epoch is built of. Errors: kInvalidArgument as a scene's file has them.
  [[nodiscard]] Result<ScenePtr> scene_of(const v1::JournalEpoch& epoch);
  /// The state, with the scene to which it belongs. Errors: the same; kInvalidArgument where the
  /// state cannot be read.
  [[nodiscard]] Result<world::WorldState> state_of(const v1::JournalCheckpoint& checkpoint);

 private:
  [[nodiscard]] Result<ScenePtr> read(const v1::JournalScene& message, ScenePtr& last) const;

  ScenePtr header_;
  world::ArmModels models_;
  std::string directory_;                          ///< where models are
  ScenePtr base_, changed_;                        ///< as they were read last
  std::unique_ptr<const world::WorldState> like_;  ///< some state of the scene that was asked last
};

}  // namespace aprsim::server::journal
