#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "protocols/ports/scene_drafts.hpp"
#include "server/drafts/draft_thread.hpp"
#include "server/drafts/scene_sources.hpp"

namespace aprsim::server {

/// Builds the cells of scenes that pages edit, on a thread of its own with a low priority. A draft
/// may name the files that a sent scene may name, and its devices are left out: they may act on
/// something outside.
class DraftBuilder final : public web::SceneDrafts {
 public:
  /// `scene` is the one that the daemon was started with.
  explicit DraftBuilder(std::shared_ptr<const scene::Scene> scene);
  ~DraftBuilder() override = default;
  DraftBuilder(const DraftBuilder&) = delete;
  DraftBuilder& operator=(const DraftBuilder&) = delete;

  [[nodiscard]] web::SceneSource source_of(const api::CellDescription& cell) override;
  void build(std::string text, std::string name, Answer answer) override;
  /// Refuses what waits and all later requests. Thread: the owner's.
  void stop() { thread_.stop(); }

 private:
  struct Request {
    std::string text, name;
  };

  [[nodiscard]] Result<web::SceneDraft> make(const Request& request);

  std::shared_ptr<const scene::Scene> scene_;
  std::mutex mutex_;
  SceneSources sources_;
  DraftThread thread_;  // last: it uses all of the above
};

}  // namespace aprsim::server
