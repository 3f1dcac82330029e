#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "world/api/snapshot/robot_snapshot.hpp"
#include "world/api/values/guard.hpp"

namespace aprsim::robot {

/// Monitors the guards of a robot's running command in simulated time. A copyable value. Thread:
/// sim.
class GuardMonitor {
 public:
  /// Starts monitoring for the command with that ticket; 1 to api::kMaxGuards guards.
  void begin(api::Ticket ticket, std::span<const api::Guard> guards);
  /// Stops monitoring; state() stays readable.
  void reset() {
    active_ = triggered_ = false;
    triggered_at_.reset();
    reaction_at_.reset();
  }
  /// The command is over; state() stays readable.
  void end() { active_ = false; }

  /// Checks the guards that are due; the first call after begin() checks all of them and samples
  /// the values that increases are measured from. Returns the guard that triggers, `delay` after
  /// its trigger. The monitor is inactive from the trigger on. `robot` is the state at `now`.
  [[nodiscard]] std::optional<std::size_t> check(const api::RobotSnapshot& robot, SimTime now,
                                                 SimTime delay = SimTime::zero());

  /// The robot has come to rest at `now`: the end of a trigger's stop time.
  void at_rest(SimTime now);

  [[nodiscard]] bool active() const { return active_; }
  /// A guard has triggered, and its reaction is still to come.
  [[nodiscard]] bool reaction_due() const { return reaction_at_.has_value(); }
  /// A trigger whose stop has not ended yet.
  [[nodiscard]] bool stopping() const { return triggered_at_.has_value(); }
  [[nodiscard]] const api::Guard& guard(std::size_t index) const { return guards_[index]; }
  /// The first guard whose required trigger is missing; none after a trigger.
  [[nodiscard]] const api::Guard* missing_trigger() const;
  [[nodiscard]] const api::GuardsSnapshot& state() const { return state_; }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [guards, start, due, active, triggered, started, triggered_at, reaction_at, state] = self;
    io(guards, start, due, active, triggered, started, triggered_at, reaction_at, state);
    io.require(state.count <= api::kMaxGuards && state.trigger_guard < api::kMaxGuards,
               "more guards than a command has");
  }

 private:
  std::array<api::Guard, api::kMaxGuards> guards_;
  std::array<double, api::kMaxGuards> start_{};  // values that increases are measured from
  std::array<SimTime, api::kMaxGuards> due_{};   // next check
  bool active_ = false, triggered_ = false, started_ = false;
  std::optional<SimTime> triggered_at_;
  std::optional<SimTime> reaction_at_;  // of a trigger whose delay has not passed
  api::GuardsSnapshot state_;
};

}  // namespace aprsim::robot
