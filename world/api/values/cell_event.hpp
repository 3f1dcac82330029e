#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "world/base/time.hpp"

/// Events of the cell. The simulation reports each one once, in order and without loss, whether or
/// not anybody reads them.
namespace aprsim::api {

/// In the order of aprsim.v1.CellEventKind, without its zero.
enum class CellEventKind {
  kGrasped,         ///< a robot holds a body
  kReleased,        ///< it released it; the text says if the gripper was not commanded to open
  kLost,            ///< a body or tool has fallen out of the cell, or was taken out
  kContactBegun,    ///< two things touch; the text names the parts of robots
  kContactEnded,    ///< they have not touched for kApartSteps
  kMerged,          ///< contact simplification ties things to others; see the text
  kWoken,           ///< contact simplification has separated them again
  kProtectiveStop,  ///< of a robot, with the reason
  kFaultBegun,      ///< an injected one
  kFaultEnded,
  kWorldStopped,     ///< the simulation has stopped on a fault of its own
  kReported,         ///< a client has reported an event: the name
  kCommandBegun,     ///< a robot has taken a command
  kCommandDone,      ///< has carried it out
  kCommandFailed,    ///< has refused it or given it up
  kDriveTripped,     ///< the belt's
  kCommandReplaced,  ///< a newer command came before it was done
  kReset,            ///< the cell was reset, or continues from the named saved state
  kEdited,           ///< the scene was changed; see the text
  kRefused,          ///< a listener has refused something; in journals and replays alone
};
inline constexpr int kCellEventKinds = static_cast<int>(CellEventKind::kRefused) + 1;

/// A contact ends after so many steps without one, so that rattling is one contact.
inline constexpr std::uint64_t kApartSteps = 100;
/// Largest number of names in an event; the text mentions further ones.
inline constexpr std::size_t kMaxEventNames = 64;

struct CellEvent {
  std::uint64_t sequence = 0;  ///< from 1 since the daemon started, without gaps
  std::uint64_t epoch = 0;     ///< number of resets and loads of saved states
  std::uint64_t step = 0;      ///< since reset: after which it was so
  SimTime time{};              ///< of that step
  CellEventKind kind = CellEventKind::kReset;
  std::vector<std::string> names;  ///< of the things involved, the acting one first
  std::string text;                ///< further details
  int robot = -1;                  ///< that it is about: index into CellDescription::robots
  std::uint64_t number = 0;        ///< ticket of the command, id of the fault; 0 = none
};
using CellEventPtr = std::shared_ptr<const CellEvent>;

/// Whether the event has one of the kinds and one of the names; empty = any.
[[nodiscard]] inline bool is_wanted(const CellEvent& event, std::span<const CellEventKind> kinds,
                                    std::span<const std::string> names) {
  if (!kinds.empty() && std::ranges::find(kinds, event.kind) == kinds.end()) return false;
  return names.empty() || std::ranges::any_of(event.names, [names](const std::string& name) {
           return std::ranges::find(names, name) != names.end();
         });
}

/// The log of the latest events.
inline constexpr std::size_t kKeptEvents = 16'384;

/// The events of a cell as they are kept.
class EventSource {
 public:
  struct Batch {
    std::vector<CellEventPtr> events;  ///< in their order
    std::uint64_t oldest = 0;          ///< that is kept; 0 = none yet
    std::uint64_t latest = 0;          ///< 0 = none yet
  };
  virtual ~EventSource() = default;
  /// The events after number `after`, at most `most` of them and at most 256. If some of them have
  /// left the log, those from `oldest` on. Thread: any, never blocks for longer than it takes
  /// to copy pointers.
  [[nodiscard]] virtual Batch after(std::uint64_t after, std::size_t most) const = 0;
  /// Waits for an event after number `after`, or the deadline. Thread: any but the simulation's and
  /// a listener's I/O thread.
  virtual void wait_after(std::uint64_t after,
                          std::chrono::steady_clock::time_point deadline) const = 0;
  /// Bytes of memory that the kept events take. Thread: any.
  [[nodiscard]] virtual std::size_t memory() const = 0;
};

}  // namespace aprsim::api
