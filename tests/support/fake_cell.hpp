#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "world/api/ports/ports.hpp"

namespace aprsim::test {

/// A six-joint "fanuc", a seven-joint "motoman" and a belt of 0.3 m/s.
[[nodiscard]] std::shared_ptr<const api::CellDescription> two_robot_cell();
/// The first snapshot of such a cell, everything at rest.
[[nodiscard]] api::SnapshotPtr at_rest(std::shared_ptr<const api::CellDescription> cell);

/// The two ports across the thread boundary without a simulation: records what is submitted, shows
/// what the test makes up. Thread: any.
class FakeCell final : public api::CommandSink, public api::SnapshotSource {
 public:
  /// Treatment of commands about time, belt and intruder; those to robots are recorded only.
  enum class Commands : std::uint8_t {
    kHeld,     ///< nothing before apply()
    kApplied,  ///< they take effect at once, each in a snapshot of its own
  };
  explicit FakeCell(Commands commands = Commands::kHeld,
                    api::SnapshotPtr first = at_rest(two_robot_cell()));

  [[nodiscard]] Result<api::Ticket> submit(api::Command command) override;
  [[nodiscard]] api::SnapshotPtr latest() const override;
  [[nodiscard]] api::SnapshotPtr wait_newer(
      const api::SnapshotPtr& seen, std::chrono::steady_clock::time_point deadline) const override;

  [[nodiscard]] std::string problem() const override;
  /// From now on problem() says this.
  void complain(const std::string& problem);

  /// Publishes the next snapshot with the test's changes: one step later, unless paused.
  void publish(const std::function<void(api::Snapshot&)>& change);
  /// Publishes that a robot has begun `ticket` and how far it is with it.
  void report(int robot, api::Ticket ticket, api::ActionState state,
              const std::string& description = "");

  /// From now on commands wait for apply().
  void hold();
  /// The commands that wait take effect in one snapshot.
  void apply();
  /// From now on the drive keeps a setting above the belt's limit as the limit.
  void limit_speed();
  /// From now on submit() fails with this; nullopt: accepts again.
  void refuse(std::optional<Error> refusal);

  /// All commands so far; the one with ticket t is at t - 1.
  [[nodiscard]] std::vector<api::Command> commands() const;
  /// Waits until at least `count` commands have been submitted; false when that takes too long.
  [[nodiscard]] bool wait_for_commands(
      std::size_t count, std::chrono::milliseconds limit = std::chrono::seconds(10)) const;

 private:
  void apply_waiting();
  void apply(const api::ConveyorCommand& command, api::Snapshot& next) const;
  static void apply(const api::SimulationCommand& command, api::Snapshot& next);

  mutable std::mutex mutex_;  // of all below
  mutable std::condition_variable changed_;
  api::SnapshotPtr latest_;
  std::vector<api::Command> commands_;
  std::size_t applied_ = 0;  // of commands_
  bool held_, speed_limited_ = false;
  std::optional<Error> refusal_;
  std::string problem_;
};

}  // namespace aprsim::test
