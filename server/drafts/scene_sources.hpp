#pragma once

#include <deque>
#include <memory>
#include <string>
#include <utility>

#include "protocols/ports/scene_drafts.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server {

/// The texts from which this daemon's cells were made: of the scene that it was started with, of
/// shipped scenes and of drafts. Thread: one at a time.
class SceneSources {
 public:
  explicit SceneSources(std::shared_ptr<const scene::Scene> scene) : scene_(std::move(scene)) {}

  [[nodiscard]] web::SceneSource find(const api::CellDescription& cell) const;
  /// Keeps the text of a draft, whose whole text is `composed`, among the latest, of which there
  /// are 4 MB.
  void keep(std::string composed, std::string text);

 private:
  std::shared_ptr<const scene::Scene> scene_;
  std::deque<std::pair<std::string, std::string>> drafts_;  ///< composed text, text
};

}  // namespace aprsim::server
