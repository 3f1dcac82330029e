#pragma once

#include <memory>
#include <string>

#include "aprsim/v1/journal.pb.h"
#include "world/base/result.hpp"
#include "world/cell/world.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server::journal {

/// Reads the scenes of a run's epochs and checkpoints, and the states of checkpoints. Thread: one
/// at a time.
class RecordedScenes {
 public:
  using ScenePtr = std::shared_ptr<const scene::Scene>;

  /// `scene`: the header's. Throws std::runtime_error where its models cannot be read.
  explicit RecordedScenes(ScenePtr scene);

  [[nodiscard]] const ScenePtr& of_header() const { return header_; }
  [[nodiscard]] const world::ArmModels& models() const { return models_; }

  /// The scene of an epoch's world. Errors: kInvalidArgument as for a scene file.
  [[nodiscard]] Result<ScenePtr> scene_of(const v1::JournalEpoch& epoch);
  /// The state with its scene. Errors: as scene_of(); kInvalidArgument where the state cannot be
  /// read.
  [[nodiscard]] Result<world::WorldState> state_of(const v1::JournalCheckpoint& checkpoint);

 private:
  [[nodiscard]] Result<ScenePtr> read(const v1::JournalScene& message, ScenePtr& last) const;

  ScenePtr header_;
  world::ArmModels models_;
  std::string directory_;                          ///< of the models
  ScenePtr base_, changed_;                        ///< as read last
  std::unique_ptr<const world::WorldState> like_;  ///< a state of the scene queried last
};

}  // namespace aprsim::server::journal
