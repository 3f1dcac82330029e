#include "server/operations/rejection_bookmarks.hpp"

#include <new>

#include "protocols/net/limited_log.hpp"

namespace aprsim::server {

void RejectionBookmarks::refused(std::string_view source, std::string_view what) try {
  {
    const std::lock_guard lock(mutex_);
    auto limit = limits_.find(source);
    if (limit == limits_.end()) {
      limit = limits_.try_emplace(std::string(source), kPerSecond, kBurst).first;
    }
    if (!limit->second.admit(protocols::RateLimit::Clock::now())) return;
  }
  const auto seen = source_.latest();
  const std::string text = protocols::log_text(what);
  bookmarks_.add({seen->epoch, seen->step}, api::BookmarkKind::kRefusal,
                 std::string(source) + ": refused: " + text);
  if (journal_ != nullptr) journal_->refused(*seen, source, text);
} catch (const std::bad_alloc&) {
  // The moment can be found without a bookmark.
}

}  // namespace aprsim::server
