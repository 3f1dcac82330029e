#pragma once

#include <memory>
#include <string>

#include "protocols/ports/scenario_drafts.hpp"
#include "server/drafts/draft_thread.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server {

/// Checks scenarios that pages edit, on a thread of its own with a low priority.
class ScenarioChecker final : public web::ScenarioDrafts {
 public:
  /// `scene` is the one that the daemon was started with.
  explicit ScenarioChecker(const std::shared_ptr<const scene::Scene>& scene);
  ~ScenarioChecker() override = default;
  ScenarioChecker(const ScenarioChecker&) = delete;
  ScenarioChecker& operator=(const ScenarioChecker&) = delete;

  [[nodiscard]] Result<web::ScenarioSource> find(const std::string& name) override;
  void check(std::string text, Answer answer) override;
  /// Refuses what waits and all later requests. Thread: the owner's.
  void stop() { thread_.stop(); }

 private:
  [[nodiscard]] web::ScenarioCheck examine(const std::string& text) const;

  std::string scene_file_;  ///< absolute
  DraftThread thread_;      // last: it uses all of the above
};

}  // namespace aprsim::server
