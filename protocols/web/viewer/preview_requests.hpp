#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <vector>

#include "aprsim/v1/web.pb.h"
#include "world/api/ports/move_previews.hpp"
#include "world/api/ports/ports.hpp"

namespace aprsim::web {

/// Viewers' requests for previews of moves, one of each viewer at a time. Thread: the server's.
class PreviewRequests {
 public:
  struct Answer {
    std::uint64_t viewer = 0;
    std::uint32_t request = 0;
    Result<api::MovePreview> preview;
  };

  /// Must outlive this object; null = there are none.
  explicit PreviewRequests(api::MovePreviews* previews) : previews_(previews) {}

  /// Errors: field and value of a wrong request; kFailedPrecondition without previews; kUnavailable
  /// while the viewer's last one is being planned.
  [[nodiscard]] Result<void> ask(std::uint64_t viewer, const v1::ViewerRequest& request,
                                 const api::Snapshot& snapshot);
  /// Answers since the last call.
  [[nodiscard]] std::vector<Answer> take_answers();
  void forget(std::uint64_t viewer) { pending_.erase(viewer); }

 private:
  /// Outlives this object while an answer is pending.
  struct Mailbox {
    std::mutex mutex;
    std::vector<Answer> answers;
  };

  api::MovePreviews* previews_;
  std::shared_ptr<Mailbox> mailbox_ = std::make_shared<Mailbox>();
  std::set<std::uint64_t> pending_;  ///< viewers
};

}  // namespace aprsim::web
