#pragma once

#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include "world/api/commands/robot_command.hpp"

namespace aprsim::robot {

/// A command that came while the tool changer was busy, to be executed after it.
struct DeferredCommand {
  api::Ticket ticket = 0;
  api::RobotAction action;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [ticket, action] = self;
    io(ticket, action);
  }
};

/// Whether the command is executed even while the tool changer works.
[[nodiscard]] inline bool precedes_tool_change(const api::RobotAction& action) {
  return std::holds_alternative<api::InitRobot>(action) ||
         std::holds_alternative<api::EndProgram>(action) ||
         std::holds_alternative<api::StopMotion>(action);
}

/// A tool change: waits until the arm is at rest, switches the valve, and then waits for the lock.
/// Commands that come meanwhile are deferred in their order. A copyable value. Thread: sim.
class ToolChangeSequence {
 public:
  /// `tool`: on the flange at the start, -1 = none.
  explicit ToolChangeSequence(int tool) : tool_(tool) { deferred_.reserve(kMaxDeferred); }

  /// Opens or closes the lock, which takes `lock_steps` once the arm is at rest.
  void begin(bool open, std::int64_t lock_steps);
  /// Drops the deferred commands, and the change itself while it waits for the arm. A valve that
  /// has been switched stays so.
  void cancel();
  /// One step; returns whether the lock has reached its end position. A closing lock takes
  /// `tool_at_flange` (-1 = none), unless the flange has a tool already.
  bool step(bool arm_at_rest, int tool_at_flange);

  [[nodiscard]] bool busy() const { return phase_ != Phase::kIdle; }
  /// On the flange, -1 = none.
  [[nodiscard]] int tool() const { return tool_; }
  /// The lock has closed, or is to close, without a tool.
  [[nodiscard]] bool closed_on_nothing() const { return !open_ && tool_ < 0; }

  /// False when kMaxDeferred commands wait already. Does not allocate for itself.
  [[nodiscard]] bool defer(api::Ticket ticket, const api::RobotAction& action);
  [[nodiscard]] const std::vector<DeferredCommand>& deferred() const { return deferred_; }
  /// Removes the oldest one; there must be one.
  [[nodiscard]] DeferredCommand take_deferred();

  static constexpr std::size_t kMaxDeferred = 16;  // also in the error text

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [tool, phase, open, lock_steps, deferred] = self;
    io(tool, phase, open, lock_steps, deferred);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.index_or_none(In::kTool, tool_);
    in.require(deferred_.size() <= kMaxDeferred && lock_steps_ >= 0,
               "more deferred commands than a robot keeps");
  }

 private:
  enum class Phase {
    kIdle,
    kWaiting,  ///< for the arm to come to rest
    kLocking,  ///< the valve is switched
  };
  friend constexpr Phase last_of(Phase) { return Phase::kLocking; }

  int tool_;
  Phase phase_ = Phase::kIdle;
  bool open_ = false;
  std::int64_t lock_steps_ = 0;  ///< until the lock is at its end position
  std::vector<DeferredCommand> deferred_;
};

}  // namespace aprsim::robot
