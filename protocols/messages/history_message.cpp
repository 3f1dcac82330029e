#include "protocols/messages/history_message.hpp"

#include <chrono>

#include <fmt/format.h>

#include "protocols/messages/codecs.hpp"
#include "world/api/commands/simulation_command.hpp"
#include "world/api/ports/history_fields.hpp"

namespace aprsim::protocols {
void write_message(const std::vector<api::HistorySpan>& spans, v1::GetHistoryResponse& message) {
  for (const api::HistorySpan& span : spans) write_fields(span, *message.add_spans());
}

void write_message(const api::Bookmark& bookmark, v1::Bookmark& message) {
  write_fields(bookmark, message);
}

void write_message(const std::vector<api::Bookmark>& bookmarks,
                   v1::ListBookmarksResponse& message) {
  for (const api::Bookmark& bookmark : bookmarks) write_fields(bookmark, *message.add_bookmarks());
}

api::Moment to_moment(const v1::Moment& message) { return {message.epoch(), message.step()}; }

api::LoadState resumption(api::Moment moment, const api::PastMoment& past) {
  const double time_s = std::chrono::duration<double>(past.snapshot->time).count();
  return {fmt::format("{:.3f} s of run {}", time_s, moment.epoch), past.state};
}

}  // namespace aprsim::protocols
