#include "protocols/messages/history_message.hpp"

#include <chrono>

#include <fmt/format.h>

#include "protocols/messages/write_message.hpp"
#include "world/api/commands/simulation_command.hpp"

namespace aprsim::protocols {
namespace {

void write_moment(api::Moment moment, v1::Moment& message) {
  message.set_epoch(moment.epoch);
  message.set_step(moment.step);
}

v1::BookmarkKind bookmark_kind(api::BookmarkKind kind) {
  static_assert(static_cast<int>(api::BookmarkKind::kStopped) + 1 == v1::BOOKMARK_KIND_STOPPED);
  return static_cast<v1::BookmarkKind>(static_cast<int>(kind) + 1);
}

}  // namespace

void write_message(const std::vector<api::HistorySpan>& spans, v1::GetHistoryResponse& message) {
  for (const api::HistorySpan& span : spans) {
    auto& to = *message.add_spans();
    to.set_epoch(span.epoch);
    to.set_first_step(span.first_step);
    to.set_last_step(span.last_step);
    write_message(span.first_time, *to.mutable_first_time());
    write_message(span.last_time, *to.mutable_last_time());
    to.set_seed(span.seed);
    if (span.loaded_state) to.set_loaded_state(*span.loaded_state);
  }
}

void write_message(const api::Bookmark& bookmark, v1::Bookmark& message) {
  message.set_id(bookmark.id);
  write_moment(bookmark.moment, *message.mutable_moment());
  write_message(bookmark.time, *message.mutable_sim_time());
  message.set_kind(bookmark_kind(bookmark.kind));
  message.set_text(bookmark.text);
}

void write_message(const std::vector<api::Bookmark>& bookmarks,
                   v1::ListBookmarksResponse& message) {
  for (const api::Bookmark& bookmark : bookmarks) write_message(bookmark, *message.add_bookmarks());
}

api::Moment to_moment(const v1::Moment& message) { return {message.epoch(), message.step()}; }

api::LoadState resumption(api::Moment moment, const api::PastMoment& past) {
  const double time_s = std::chrono::duration<double>(past.snapshot->time).count();
  return {fmt::format("{:.3f} s of run {}", time_s, moment.epoch), past.state};
}

}  // namespace aprsim::protocols
