#pragma once

#include <functional>
#include <memory>
#include <string>

#include "protocols/ports/scenario_drafts.hpp"
#include "server/drafts/draft_thread.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server {

/// Checks scenarios that pages edit, on a thread of its own with a low priority.
class ScenarioChecker final : public web::ScenarioDrafts {
 public:
  /// `scene`: the present one, of a text its file does not exist. Thread: any.
  explicit ScenarioChecker(std::function<std::shared_ptr<const scene::Scene>()> scene);
  ~ScenarioChecker() override = default;
  ScenarioChecker(const ScenarioChecker&) = delete;
  ScenarioChecker& operator=(const ScenarioChecker&) = delete;

  [[nodiscard]] Result<web::ScenarioSource> find(const std::string& name) override;
  void check(std::string text, Answer answer) override;
  /// Refuses what waits and all later requests. Thread: the owner's.
  void stop() { thread_.stop(); }

 private:
  [[nodiscard]] web::ScenarioCheck examine(const std::string& text) const;
  /// Absolute.
  [[nodiscard]] std::string scene_file() const;
  /// The same, or that of the first scene: one that came as a text has no file to be named.
  [[nodiscard]] std::string named_file() const;

  const std::function<std::shared_ptr<const scene::Scene>()> scene_;
  const std::string first_file_;  ///< of the scene at the start, absolute
  DraftThread thread_;            // last: it uses all of the above
};

}  // namespace aprsim::server
