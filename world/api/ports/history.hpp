#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "world/api/snapshot/snapshot.hpp"
#include "world/api/values/state_ptr.hpp"
#include "world/base/result.hpp"
#include "world/base/time.hpp"

/// The recorded past of a run. Queries never slow down the cell.
namespace aprsim::api {

/// A moment of a run: after a step, before what was commanded then.
struct Moment {
  std::uint64_t epoch = 0;  ///< resets and loads of saved states before it
  std::uint64_t step = 0;   ///< since the last reset
  auto operator<=>(const Moment&) const = default;
};

/// The recorded steps of one epoch, without a gap.
struct HistorySpan {
  std::uint64_t epoch = 0;
  std::uint64_t first_step = 0, last_step = 0;
  SimTime first_time{}, last_time{};  ///< of these steps
  std::uint64_t seed = 0;
  std::optional<std::string> loaded_state;  ///< name of the state that the epoch began with
};

/// The reason for a bookmark.
enum class BookmarkKind : std::uint8_t {
  kOwn,             ///< set by a client
  kCommand,         ///< a robot, the belt, an intruder or a fault was commanded
  kRefusal,         ///< a command was refused, or ended in an error
  kGrasp,           ///< a robot holds something from then on
  kRelease,         ///< a robot holds it no more
  kProtectiveStop,  ///< a robot has stopped
  kFault,           ///< an injected fault has begun, the belt's drive has tripped, a part is lost
  kStopped,         ///< the world has stopped on a fault of its own
};

struct Bookmark {
  std::uint64_t id = 0;  ///< from 1; never used again
  Moment moment;
  SimTime time{};  ///< of the moment
  BookmarkKind kind = BookmarkKind::kOwn;
  std::string text;
};

inline constexpr std::size_t kMaxBookmarkText = 200;  ///< [bytes]
inline constexpr std::size_t kMaxOwnBookmarks = 200;

/// How the cell was.
struct PastMoment {
  SnapshotPtr snapshot;  ///< as published then, without fields of the simulation itself
  StatePtr state;        ///< to go on from
};

class History {
 public:
  virtual ~History() = default;

  /// In their order. Thread: any.
  [[nodiscard]] virtual std::vector<HistorySpan> spans() const = 0;
  using Answer = std::function<void(Result<PastMoment>)>;
  /// Works a moment out and calls `answer`, once, from a thread of the history's own, for which it
  /// must not wait; or at once, here, with an error: kNotFound for a moment that is not kept,
  /// kUnavailable when too many wait or the history ends. Thread: any.
  virtual void ask(Moment moment, Answer answer) = 0;

  /// In the order of their moments. Thread: any.
  [[nodiscard]] virtual std::vector<Bookmark> bookmarks() const = 0;
  /// Rises with every change of the bookmarks. Thread: any.
  [[nodiscard]] virtual std::uint64_t bookmark_revision() const = 0;
  /// Returns it with its number. Errors: kNotFound for a moment that is not kept, kInvalidArgument
  /// for the text, kFailedPrecondition when there are kMaxOwnBookmarks. Thread: any.
  [[nodiscard]] virtual Result<Bookmark> add_bookmark(Moment moment, std::string text) = 0;
  /// Errors: kNotFound. Thread: any.
  [[nodiscard]] virtual Result<void> remove_bookmark(std::uint64_t id) = 0;
};

}  // namespace aprsim::api
