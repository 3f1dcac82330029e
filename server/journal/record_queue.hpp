#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <variant>

#include "protocols/ports/wire_trace.hpp"
#include "world/runtime/record/recorder.hpp"

namespace aprsim::server::journal {

using WallTime = std::chrono::system_clock::time_point;

struct EpochBegun {
  world::RunTime time;
  std::uint64_t seed = 0;
  std::optional<std::string> loaded;
  std::shared_ptr<const scene::Scene> scene;
};
struct CommandApplied {
  world::RunTime time;
  std::uint64_t sequence = 0;
  world::QueuedCommand command;
  std::string failure;
};
struct StateSampled {
  world::RunTime time;
  world::StateSample sample;
};
struct StateSaved {
  world::RunTime time;
  std::uint64_t hash = 0;
  std::shared_ptr<const world::WorldState> state;
};
struct WorldStopped {
  world::RunTime time;
  std::string why;
};
/// A request that a listener refused before the cell saw it.
struct Refused {
  world::RunTime time;
  std::chrono::nanoseconds sim_time{};
  std::string listener, what;
};
/// Records that are missing because there was no room.
struct Missing {
  std::uint64_t records = 0, commands = 0;
  WallTime begin{}, end{};
  std::string reason;
  [[nodiscard]] bool any() const { return records > 0; }
  void add(const Missing& more);
};

struct Entry {
  WallTime wall;
  std::variant<EpochBegun, CommandApplied, StateSampled, StateSaved, WorldStopped,
               api::CellEventPtr, Refused, protocols::WireRecord>
      what;

  /// Memory, approximately.
  [[nodiscard]] std::size_t bytes() const;
  /// The gap that its loss makes.
  [[nodiscard]] Missing missing(std::string reason = {}) const;
};

/// Bounded queue from any thread to the writer. The lock is held for a push or a swap. An entry
/// that finds no room is counted as missing at its place.
class RecordQueue {
 public:
  struct Taken {
    std::deque<Entry> entries;
    Missing missing;  ///< after all entries
  };
  enum class Pushed {
    kTaken,
    kPressing,  ///< accepted, and the queue is half full with it
    kMissing,   ///< rejected, as are all later ones until the next take()
  };

  explicit RecordQueue(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// Thread: any.
  Pushed push(Entry entry);
  /// Counts entries that could not be created. Thread: any.
  void lose(const Missing& missing);
  /// Memory of the entries, approximately. Thread: any.
  [[nodiscard]] std::size_t bytes() const;
  /// Takes all entries. After a missing one the queue accepts no more until this call, so that the
  /// gap keeps its place. Thread: the writer.
  void take(Taken& taken);

 private:
  const std::size_t max_bytes_;
  mutable std::mutex mutex_;
  // A deque: its growth moves no entries while the lock is held.
  std::deque<Entry> entries_;
  std::size_t bytes_ = 0;
  Missing missing_;
};

}  // namespace aprsim::server::journal
