#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "world/api/commands/command.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/base/result.hpp"

/// The two ways across the thread boundary: commands in, snapshots out.
namespace aprsim::api {

class CommandSink {
 public:
  virtual ~CommandSink() = default;
  /// Queues a command for the next step boundary. Never waits: a full queue is kUnavailable.
  /// An index out of range or a non-finite number is refused here with the field's name.
  /// Thread: any.
  [[nodiscard]] virtual Result<Ticket> submit(Command command) = 0;
};

class SnapshotSource {
 public:
  virtual ~SnapshotSource() = default;
  /// The latest snapshot; never null. Thread: any, never blocks for longer than a pointer copy.
  [[nodiscard]] virtual SnapshotPtr latest() const = 0;
  /// Waits until a snapshot other than `seen` has been published, or until the deadline; returns
  /// the latest. Thread: any but the simulation's, and not a listener's I/O thread.
  [[nodiscard]] virtual SnapshotPtr wait_newer(
      const SnapshotPtr& seen, std::chrono::steady_clock::time_point deadline) const = 0;
  /// The same, but those before `step` of the same epoch may pass without waking the caller, unless
  /// the world has a fault. Thread: as above.
  [[nodiscard]] virtual SnapshotPtr wait_for_step(
      const SnapshotPtr& seen, std::uint64_t /*step*/,
      std::chrono::steady_clock::time_point deadline) const {
    return wait_newer(seen, deadline);
  }
  /// The reason why the simulation does not run as requested, in a sentence; empty = it does. Such
  /// as a fault of the world, a blocked thread, or a pace far below the requested one. Thread: any.
  [[nodiscard]] virtual std::string problem() const = 0;
};

}  // namespace aprsim::api
