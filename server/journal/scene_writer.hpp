#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "aprsim/v1/journal.pb.h"
#include "server/journal/record_queue.hpp"
#include "server/journal/state_seal.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server::journal {

/// Writes the scenes of epochs and checkpoints where they differ from the header's, and signs
/// checkpoints. Thread: one at a time.
class SceneWriter {
 public:
  /// `seal` outlives the writer.
  SceneWriter(const v1::JournalHeader& header, const StateSeal& seal);

  /// Writes the scene of an epoch or checkpoint into its record; does nothing for other entries.
  /// Throws std::runtime_error for a scene without a text, and for an unreadable robot description.
  void write(const Entry& entry, v1::JournalRecord& record);
  /// Writes the scenes of a state into its checkpoint, which has the state, and signs it.
  void write(const world::WorldState& state, v1::JournalCheckpoint& checkpoint);

 private:
  using ScenePtr = std::shared_ptr<const scene::Scene>;
  /// A scene and its message, kept because comparing is cheaper than writing.
  struct Written {
    ScenePtr scene;
    v1::JournalScene message;
  };
  [[nodiscard]] const v1::JournalScene& message_of(const ScenePtr& scene, Written& last);

  const std::string header_text_;
  std::map<std::string, std::string> models_;  ///< of the header: name, digest
  const StateSeal& seal_;
  Written base_, changed_;
};

}  // namespace aprsim::server::journal
