#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "world/recorder.hpp"

namespace aprsim::server::journal {

using WallTime = std::chrono::system_clock::time_point;

struct EpochBegun {
  world::RunTime time;
  std::uint64_t seed = 0;
  std::optional<std::string> loaded;
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
  std::variant<EpochBegun, CommandApplied, StateSampled, StateSaved, WorldStopped> what;

  /// Of memory; approximately.
  [[nodiscard]] std::size_t bytes() const;
};

/// Bounded queue from the threads that know something to the one that writes it. The lock is held
/// for a push or a swap of two vectors. What finds no room is counted as missing in its place.
class RecordQueue {
 public:
  struct Taken {
    std::vector<Entry> entries;
    Missing missing;  ///< came after all of them
  };

  explicit RecordQueue(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// Thread: any. False when it is missing from now on.
  bool push(Entry entry);
  /// Waits for entries or the deadline. After what is missing nothing more is taken in until this
  /// has been called, so that the gap stands where it was. Thread: the writer.
  void take(Taken& taken, std::chrono::steady_clock::time_point deadline);
  /// Ends waits. Thread: any.
  void close();

 private:
  const std::size_t max_bytes_;
  std::mutex mutex_;
  std::condition_variable filled_;
  std::vector<Entry> entries_;
  std::size_t bytes_ = 0;
  Missing missing_;
  bool closed_ = false;
};

}  // namespace aprsim::server::journal
