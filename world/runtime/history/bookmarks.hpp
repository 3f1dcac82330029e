#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "world/api/ports/history.hpp"

namespace aprsim::world {

inline constexpr std::size_t kMaxBookmarks = 2000;

/// Bookmarks of moments: those of clients, and the latest kMaxBookmarks automatic ones. Thread:
/// any.
class Bookmarks {
 public:
  /// Adds an automatic bookmark.
  void add(api::Moment moment, api::BookmarkKind kind, std::string text);
  /// Adds a client's bookmark. Errors: see api::History.
  [[nodiscard]] Result<api::Bookmark> add(api::Moment moment, std::string text);
  [[nodiscard]] Result<void> remove(std::uint64_t id);
  /// All bookmarks, ordered by moment; times are not filled in.
  [[nodiscard]] std::vector<api::Bookmark> all() const;
  [[nodiscard]] std::uint64_t revision() const { return revision_; }

 private:
  void insert(std::vector<api::Bookmark>& into, api::Bookmark bookmark);

  mutable std::mutex mutex_;
  std::vector<api::Bookmark> automatic_, own_;  ///< ordered by moment
  std::uint64_t next_id_ = 1;
  std::atomic<std::uint64_t> revision_{0};
};

}  // namespace aprsim::world
