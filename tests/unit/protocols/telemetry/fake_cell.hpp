#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "world/api/ports.hpp"

namespace aprsim::test {

/// A cell without physics: takes commands, applies the ones about time and the belt at once, and
/// publishes a snapshot after each. Can be told to leave commands lying or to refuse them.
class FakeCell final : public api::CommandSink, public api::SnapshotSource {
 public:
  /// One robot with two joints, one gear, one tray with a slot, a belt; and as many more gears.
  explicit FakeCell(int more_gears = 0);

  [[nodiscard]] Result<api::Ticket> submit(api::Command command) override;
  [[nodiscard]] api::SnapshotPtr latest() const override;
  [[nodiscard]] api::SnapshotPtr wait_newer(
      const api::SnapshotPtr& seen, std::chrono::steady_clock::time_point deadline) const override;

  /// Publishes a changed copy of the latest snapshot.
  void publish(const std::function<void(api::Snapshot&)>& change);
  /// Commands received so far.
  [[nodiscard]] std::vector<api::Command> commands() const;
  /// While false, commands are taken but never take effect.
  void set_applying(bool applying);
  /// While set, commands are refused with this.
  void set_refusal(std::optional<Error> refusal);

 private:
  void apply(const api::Command& command, api::Ticket ticket, api::Snapshot& snapshot) const;

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  api::SnapshotPtr latest_;
  std::vector<api::Command> commands_;
  std::optional<Error> refusal_;
  bool applying_ = true;
};

}  // namespace aprsim::test
