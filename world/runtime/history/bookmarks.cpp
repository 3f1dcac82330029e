#include "world/runtime/history/bookmarks.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace aprsim::world {

void Bookmarks::insert(std::vector<api::Bookmark>& into, api::Bookmark bookmark) {
  const auto at = std::ranges::upper_bound(into, bookmark.moment, {}, &api::Bookmark::moment);
  into.insert(at, std::move(bookmark));
  ++revision_;
}

void Bookmarks::add(api::Moment moment, api::BookmarkKind kind, std::string text) {
  text.resize(std::min(text.size(), api::kMaxBookmarkText));
  const std::lock_guard lock(mutex_);
  // Dropped in batches: each erase moves all remaining elements.
  if (automatic_.size() >= kMaxBookmarks) {
    automatic_.erase(automatic_.begin(), automatic_.begin() + kMaxBookmarks / 10);
  }
  insert(automatic_, {next_id_++, moment, {}, kind, std::move(text)});
}

Result<api::Bookmark> Bookmarks::add(api::Moment moment, std::string text) {
  if (text.size() > api::kMaxBookmarkText) {
    return fail(ErrorCode::kInvalidArgument, "text",
                std::to_string(text.size()) + " bytes are more than " +
                    std::to_string(api::kMaxBookmarkText));
  }
  const std::lock_guard lock(mutex_);
  if (own_.size() >= api::kMaxOwnBookmarks) {
    return fail(ErrorCode::kFailedPrecondition, "bookmarks",
                "all " + std::to_string(api::kMaxOwnBookmarks) +
                    " places for bookmarks are taken; remove one");
  }
  api::Bookmark bookmark{next_id_++, moment, {}, api::BookmarkKind::kOwn, std::move(text)};
  insert(own_, bookmark);
  return bookmark;
}

Result<void> Bookmarks::remove(std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  const auto of_id = [id](const api::Bookmark& bookmark) { return bookmark.id == id; };
  if (std::erase_if(own_, of_id) + std::erase_if(automatic_, of_id) == 0) {
    return fail(ErrorCode::kNotFound, "id",
                "there is no bookmark with the number " + std::to_string(id));
  }
  ++revision_;
  return {};
}

std::vector<api::Bookmark> Bookmarks::all() const {
  const std::lock_guard lock(mutex_);
  std::vector<api::Bookmark> all;
  std::ranges::merge(automatic_, own_, std::back_inserter(all), {}, &api::Bookmark::moment,
                     &api::Bookmark::moment);
  return all;
}

}  // namespace aprsim::world
