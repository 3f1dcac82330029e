#include "protocols/web/viewer/preview_requests.hpp"

#include <utility>

#include "protocols/web/viewer/viewer_command.hpp"

namespace aprsim::web {

Result<void> PreviewRequests::ask(std::uint64_t viewer, const v1::ViewerRequest& request,
                                  const api::Snapshot& snapshot) {
  if (previews_ == nullptr) {
    return fail(ErrorCode::kFailedPrecondition, "preview",
                "this daemon plans no moves: it replays a run");
  }
  auto move = preview_of(request.preview(), snapshot);
  if (!move) return tl::unexpected(move.error());
  if (!pending_.insert(viewer).second) {
    return fail(ErrorCode::kUnavailable, "preview", "the last preview is still being planned");
  }
  previews_->ask(*std::move(move),
                 [mailbox = mailbox_, viewer, id = request.id()](Result<api::MovePreview> preview) {
                   const std::lock_guard lock(mailbox->mutex);
                   mailbox->answers.push_back({viewer, id, std::move(preview)});
                 });
  return {};
}

std::vector<PreviewRequests::Answer> PreviewRequests::take_answers() {
  std::vector<Answer> answers;
  {
    const std::lock_guard lock(mailbox_->mutex);
    answers.swap(mailbox_->answers);
  }
  for (const Answer& answer : answers) pending_.erase(answer.viewer);
  return answers;
}

}  // namespace aprsim::web
