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

  /// `scene`: the header's. `directory`: where robot descriptions of other scenes are written;
  /// empty = in one of its own, which is removed with it. Throws std::runtime_error where the
  /// header's models cannot be read.
  explicit RecordedScenes(ScenePtr scene, std::string directory = {});
  ~RecordedScenes();
  RecordedScenes(const RecordedScenes&) = delete;
  RecordedScenes& operator=(const RecordedScenes&) = delete;

  [[nodiscard]] const ScenePtr& of_header() const { return header_; }
  /// The models of one of the run's scenes. Throws std::runtime_error where they cannot be read.
  [[nodiscard]] const world::ArmModels& models_of(const ScenePtr& scene);

  /// The scene of an epoch's world. Errors: kInvalidArgument as for a scene file.
  [[nodiscard]] Result<ScenePtr> scene_of(const v1::JournalEpoch& epoch);
  /// The state with its scene. Errors: as scene_of(); kInvalidArgument where the state cannot be
  /// read.
  [[nodiscard]] Result<world::WorldState> state_of(const v1::JournalCheckpoint& checkpoint);

 private:
  [[nodiscard]] Result<ScenePtr> read(const v1::JournalScene& message, ScenePtr& last);
  [[nodiscard]] Result<std::string> directory_of(const v1::JournalScene& message);

  ScenePtr header_;
  world::ArmModels header_models_;
  std::string directory_;                          ///< of the header's models
  std::string scene_directory_;                    ///< of the scenes' models; empty = none yet
  bool removes_ = false;                           ///< that directory at the end
  ScenePtr models_scene_;                          ///< the scene of models_
  world::ArmModels models_;                        ///< those that were queried last
  ScenePtr base_, changed_;                        ///< as read last
  std::unique_ptr<const world::WorldState> like_;  ///< a state of the scene queried last
};

}  // namespace aprsim::server::journal
