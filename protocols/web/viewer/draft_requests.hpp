#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "aprsim/v1/web.pb.h"
#include "protocols/ports/scene_drafts.hpp"
#include "protocols/web/viewer/web_options.hpp"

namespace aprsim::web {

/// Viewers' requests to edit the scene, one draft of each viewer at a time. Thread: the server's.
class DraftRequests {
 public:
  struct Answer {
    std::uint64_t viewer = 0;
    std::uint32_t request = 0;
    Result<SceneDraft> draft;
  };

  /// Both must outlive this object.
  DraftRequests(const WebServerOptions& options, const std::string& instance_id)
      : options_(options), instance_id_(instance_id) {}

  /// Writes the text of the present scene. Error: kFailedPrecondition where none is edited.
  [[nodiscard]] Result<void> write_source(const api::CellDescription& cell,
                                          v1::SceneSource& message);
  /// `name` is that of the present scene. Errors: kFailedPrecondition where no scene is edited;
  /// kUnavailable while the viewer's last draft is being built.
  [[nodiscard]] Result<void> build(std::uint64_t viewer, const v1::ViewerRequest& request,
                                   const std::string& name);
  /// Answers since the last call.
  [[nodiscard]] std::vector<Answer> take_answers();
  /// Writes a draft that has been built.
  void write(const Answer& answer, v1::SceneDraft& message) const;
  void forget(std::uint64_t viewer) { pending_.erase(viewer); }

 private:
  /// Outlives this object while an answer is pending.
  struct Mailbox {
    std::mutex mutex;
    std::vector<Answer> answers;
  };

  const WebServerOptions& options_;
  const std::string& instance_id_;
  std::shared_ptr<Mailbox> mailbox_ = std::make_shared<Mailbox>();
  std::set<std::uint64_t> pending_;  ///< viewers
};

}  // namespace aprsim::web
