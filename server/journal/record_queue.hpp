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
/// By a listener, before the cell saw it.
struct Refused {
  world::RunTime time;
  std::chrono::nanoseconds sim_time{};
  std::string listener, what;
};
/// What is missing because there was no room.
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

  /// Of memory; approximately.
  [[nodiscard]] std::size_t bytes() const;
  /// As if it were lost.
  [[nodiscard]] Missing missing(std::string reason = {}) const;
};

/// Bounded queue from the threads that know something to the one that writes it. The lock is held
/// for a push or a swap. What finds no room is counted as missing in its place.
class RecordQueue {
 public:
  struct Taken {
    std::deque<Entry> entries;
    Missing missing;  ///< came after all of them
  };
  enum class Pushed {
    kTaken,
    kPressing,  ///< the same, and half of the room is used with it
    kMissing,   ///< it is not taken, and nothing more until the next take()
  };

  explicit RecordQueue(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// Thread: any.
  Pushed push(Entry entry);
  /// What could not even be made is missing as well. Thread: any.
  void lose(const Missing& missing);
  /// All that is there. After what is missing nothing more is taken in until this has been called,
  /// so that the gap stands where it was. Thread: the writer.
  void take(Taken& taken);

 private:
  const std::size_t max_bytes_;
  std::mutex mutex_;
  // No growth moves what is in it while the lock is held.
  std::deque<Entry> entries_;
  std::size_t bytes_ = 0;
  Missing missing_;
};

}  // namespace aprsim::server::journal
