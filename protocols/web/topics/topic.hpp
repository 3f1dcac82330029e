#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "aprsim/v1/web.pb.h"
#include "protocols/access/role.hpp"

namespace aprsim::web {

/// Everything that a topic may know of a viewer.
struct Audience {
  const v1::Watch& watch;
  bool snapshot_due = false;  ///< it gets a snapshot of the cell at this tick
  bool idle = false;          ///< nothing that must arrive waits for it
  std::uint64_t skipped_snapshots = 0;
};

/// One subject that viewers are kept up to date on. A viewer gets its message when the subject has
/// another revision than the one that the viewer has. Thread: the server's.
struct Topic {
  using Clock = std::chrono::steady_clock;
  using Revision = std::uint64_t;
  enum class Delivery {
    kMust,     ///< arrives; a viewer that leaves too many waiting is closed
    kIfQuick,  ///< waits for its next round where much waits for the viewer
    kLatest,   ///< takes the place of one that still waits
  };

  std::string name;
  Clock::duration period{};                       ///< between rounds; 0 = each tick is one
  bool first_at_once = false;                     ///< a new viewer does not wait for a round
  protocols::Role role = protocols::Role::kView;  ///< that a viewer needs
  Delivery delivery = Delivery::kIfQuick;
  /// Whether a viewer gets it now; null = yes.
  std::function<bool(const Audience&)> wanted = {};
  /// Present revision, asked once a round; null = each round has its own.
  std::function<Revision()> revision = {};
  // One of both:
  /// Writes the message of a round, the same for all viewers. The message is empty.
  std::function<void(v1::ViewerUpdate&)> write = {};
  /// Writes a message of the viewer's own, after the revision that it has. Returns the revision
  /// that it has then. A message that stays empty is not sent.
  std::function<Revision(const Audience&, std::optional<Revision>, v1::ViewerUpdate&)> write_own =
      {};
  /// A viewer misses a message for a later one; null = nobody counts it.
  std::function<void()> on_skipped = {};
};

}  // namespace aprsim::web
