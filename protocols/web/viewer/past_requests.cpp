#include "protocols/web/viewer/past_requests.hpp"

#include "protocols/messages/history_message.hpp"
#include "protocols/messages/write_message.hpp"
#include "protocols/web/topics/topic_message.hpp"

namespace aprsim::web {

std::optional<Result<void>> PastRequests::execute(const Viewer& viewer,
                                                  const v1::ViewerRequest& request) {
  const bool concerned = request.has_past() || request.has_resume_from() ||
                         request.has_add_bookmark() || request.has_remove_bookmark();
  if (!concerned) return std::nullopt;
  if (options_.history == nullptr) {
    return fail(ErrorCode::kFailedPrecondition, "past",
                "this daemon keeps no history (history.minutes is 0)");
  }
  if (request.has_past()) {
    queries_.add({viewer.id(), request.id(), protocols::to_moment(request.past())});
    return Result<void>();
  }
  if (request.has_resume_from()) {
    const api::Moment moment = protocols::to_moment(request.resume_from().moment());
    queries_.add({viewer.id(), request.id(), moment, true});
    return Result<void>();
  }
  if (request.has_remove_bookmark()) {
    return options_.history->remove_bookmark(request.remove_bookmark().id());
  }
  const v1::AddBookmarkRequest& add = request.add_bookmark();
  const auto added = options_.history->add_bookmark(protocols::to_moment(add.moment()), add.text());
  return added ? Result<void>() : tl::unexpected(added.error());
}

void PastRequests::write(const Answer& answer, const api::CellDescription& present,
                         v1::PastSnapshot& message) {
  const api::Snapshot& snapshot = *answer.past->snapshot;
  message.set_id(answer.query.request);
  write_without_names(snapshot, instance_id_, *message.mutable_snapshot());
  if (same_scene(*snapshot.cell, present)) return;
  protocols::write_message(*snapshot.cell, *message.mutable_cell());
  appearance_.follow(*snapshot.cell, options_.visual);
  *message.mutable_appearance() = appearance_.message();
}

}  // namespace aprsim::web
