#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "aprsim/v1/web.pb.h"
#include "protocols/access/role.hpp"

namespace aprsim::web {

/// Properties of a viewer that topics may use.
struct Audience {
  const v1::Watch& watch;
  bool snapshot_due = false;  ///< it receives a snapshot at this tick
  bool idle = false;          ///< no message that must arrive is waiting
  std::uint64_t skipped_snapshots = 0;
};

/// One subject of which viewers receive updates. A viewer receives a message when its revision of
/// the subject is outdated. Thread: the server's.
struct Topic {
  using Clock = std::chrono::steady_clock;
  using Revision = std::uint64_t;
  enum class Delivery {
    kMust,     ///< must arrive; a viewer that lets too many wait is closed
    kIfQuick,  ///< skips this round while other messages wait
    kLatest,   ///< replaces an earlier one that still waits
  };

  std::string name;
  Clock::duration period{};                       ///< between rounds; 0 = each tick is one
  bool first_at_once = false;                     ///< new viewers receive it immediately
  protocols::Role role = protocols::Role::kView;  ///< needed role
  Delivery delivery = Delivery::kIfQuick;
  /// Whether a viewer receives it now; null = always.
  std::function<bool(const Audience&)> wanted = {};
  /// Current revision, read once a round; null = each round is a new revision.
  std::function<Revision()> revision = {};
  // Exactly one of these is set:
  /// Writes the common message of a round into an empty message.
  std::function<void(v1::ViewerUpdate&)> write = {};
  /// Writes a message for one viewer, with everything after its revision. Returns the new revision.
  /// An empty message is not sent.
  std::function<Revision(const Audience&, std::optional<Revision>, v1::ViewerUpdate&)> write_own =
      {};
  /// Called when a message is replaced by a later one; may be null.
  std::function<void()> on_skipped = {};
};

}  // namespace aprsim::web
