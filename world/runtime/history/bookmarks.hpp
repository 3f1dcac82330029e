#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "world/api/ports/history.hpp"

namespace aprsim::world {

inline constexpr std::size_t kMaxBookmarks = 2000;

/// Moments worth finding again; of those that nobody has set the latest kMaxBookmarks. Thread: any.
class Bookmarks {
 public:
  /// One at what has happened.
  void note(api::Moment moment, api::BookmarkKind kind, std::string text);
  /// Somebody's own. Errors: see api::History.
  [[nodiscard]] Result<api::Bookmark> add(api::Moment moment, std::string text);
  [[nodiscard]] Result<void> remove(std::uint64_t id);
  /// In the order of their moments, without their times.
  [[nodiscard]] std::vector<api::Bookmark> all() const;
  [[nodiscard]] std::uint64_t revision() const { return revision_; }

 private:
  void insert(std::vector<api::Bookmark>& into, api::Bookmark bookmark);

  mutable std::mutex mutex_;
  std::vector<api::Bookmark> noted_, own_;  ///< by their moments
  std::uint64_t next_id_ = 1;
  std::atomic<std::uint64_t> revision_{0};
};

}  // namespace aprsim::world
