#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "protocols/ports/scene_drafts.hpp"
#include "server/drafts/scene_sources.hpp"

namespace aprsim::server {

/// Builds the cells of scenes that pages edit, on a thread of its own with a low priority. A draft
/// may name the files that a sent scene may name, and its devices are left out: they may act on
/// something outside.
class DraftBuilder final : public web::SceneDrafts {
 public:
  static constexpr std::size_t kMaxWaiting = 8;

  /// `scene` is the one that the daemon was started with.
  explicit DraftBuilder(std::shared_ptr<const scene::Scene> scene);
  ~DraftBuilder() override;
  DraftBuilder(const DraftBuilder&) = delete;
  DraftBuilder& operator=(const DraftBuilder&) = delete;

  [[nodiscard]] web::SceneSource source_of(const api::CellDescription& cell) override;
  void build(std::string text, std::string name, Answer answer) override;
  /// Refuses what waits and all later requests. Thread: the owner's.
  void stop();

 private:
  struct Request {
    std::string text, name;
    Answer answer;
  };

  void run(const std::stop_token& stop);
  [[nodiscard]] Result<web::SceneDraft> make(const Request& request);

  std::shared_ptr<const scene::Scene> scene_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  SceneSources sources_;
  std::deque<Request> waiting_;
  bool ended_ = false;
  std::jthread thread_;
};

}  // namespace aprsim::server
