#pragma once

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "world/api/ports.hpp"

namespace aprsim::modbus_server::testing {

/// A cell that is nothing but a conveyor's settings behind the two ports. Commands take effect at
/// once, or when the test says so. Thread: any.
class FakeCell : public api::CommandSink, public api::SnapshotSource {
 public:
  explicit FakeCell(bool has_conveyor = true) {
    auto cell = std::make_shared<api::CellDescription>();
    cell->has_conveyor = has_conveyor;
    cell->conveyor.max_speed_m_s = kMaxSpeed;
    state_.cell = cell;
    publish();
  }

  static constexpr double kMaxSpeed = 0.3;

  Result<api::Ticket> submit(api::Command command) override {
    const std::scoped_lock lock(mutex_);
    if (refusal_) return tl::unexpected(*refusal_);
    queue_.push_back(std::get<api::ConveyorCommand>(command.body));
    commands_.push_back(queue_.back());
    endpoints_.push_back(command.endpoint);
    const api::Ticket ticket = ++issued_;
    if (!held_) apply_queue();
    return ticket;
  }

  api::SnapshotPtr latest() const override {
    const std::scoped_lock lock(mutex_);
    return snapshot_;
  }
  api::SnapshotPtr wait_newer(const api::SnapshotPtr& seen,
                              std::chrono::steady_clock::time_point deadline) const override {
    std::unique_lock lock(mutex_);
    published_.wait_until(lock, deadline, [&] { return snapshot_ != seen; });
    return snapshot_;
  }

  /// Commands wait until apply().
  void hold() {
    with_lock([this] { held_ = true; });
  }
  void apply() {
    with_lock([this] { apply_queue(); });
  }
  void refuse(std::optional<Error> error) {
    with_lock([&] { refusal_ = std::move(error); });
  }
  /// The drive keeps a setting above the belt's limit as the limit.
  void limit_settings() {
    with_lock([this] { limits_ = true; });
  }
  /// Any other change of the state, as by another client of the simulation.
  template <typename F>
  void change(F edit) {
    with_lock([&] {
      edit(state_);
      publish();
    });
  }

  [[nodiscard]] std::vector<api::ConveyorCommand> commands() const {
    const std::scoped_lock lock(mutex_);
    return commands_;
  }
  [[nodiscard]] std::vector<api::EndpointId> endpoints() const {
    const std::scoped_lock lock(mutex_);
    return endpoints_;
  }

 private:
  template <typename F>
  void with_lock(F action) {
    const std::scoped_lock lock(mutex_);
    action();
  }
  void apply_queue() {
    for (const api::ConveyorCommand& command : std::exchange(queue_, {})) {
      api::ConveyorSnapshot& conveyor = state_.conveyor;
      if (command.emergency_stop) conveyor.emergency_stop = *command.emergency_stop;
      if (command.fault_reset && !conveyor.emergency_stop) {
        conveyor.fault = api::DriveFault::kNone;
      }
      if (conveyor.emergency_stop) {
        conveyor.fault = api::DriveFault::kEmergencyStop;
        conveyor.run = false;
      }
      if (command.run) conveyor.run = *command.run && conveyor.fault == api::DriveFault::kNone;
      if (command.forward) conveyor.forward = *command.forward;
      if (command.speed_m_s) {
        conveyor.speed_setting_m_s =
            limits_ ? std::min(*command.speed_m_s, kMaxSpeed) : *command.speed_m_s;
      }
      ++state_.applied;
    }
    publish();
  }
  void publish() {
    ++state_.step;
    snapshot_ = std::make_shared<const api::Snapshot>(state_);
    published_.notify_all();
  }

  mutable std::mutex mutex_;
  mutable std::condition_variable published_;
  api::Snapshot state_;
  api::SnapshotPtr snapshot_;
  std::deque<api::ConveyorCommand> queue_;
  std::vector<api::ConveyorCommand> commands_;
  std::vector<api::EndpointId> endpoints_;
  api::Ticket issued_ = 0;
  bool held_ = false, limits_ = false;
  std::optional<Error> refusal_;
};

}  // namespace aprsim::modbus_server::testing
