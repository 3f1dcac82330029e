#pragma once

#include <cstdint>
#include <string>

namespace aprsim::world {

/// Detects that a cell is at rest: a step changes nothing but its clocks and the frames of its
/// cameras. A step is a function of the state, so every later one does the same until something
/// acts on the cell. It is proven on the complete saved state, bit for bit: once for a step with a
/// reading of the cycle's sensors, once for a step without. Thread: sim.
class Standstill {
 public:
  /// Proven, and nothing has acted on the cell since.
  [[nodiscard]] bool holds() const { return proven_with_sensors_ && proven_without_; }
  /// Something acts on the cell.
  void end() { *this = Standstill(); }

  /// Before each step of a cell of which nothing is bound to change at a later time. `state_hash`
  /// is called once in a while. True: prove() is to follow the step.
  template <typename Hash>
  [[nodiscard]] bool wants_proof(bool reads_sensors, Hash&& state_hash) {
    if (wait_steps_ > 0) {
      --wait_steps_;
      return false;
    }
    if (!candidate_) {
      const std::uint64_t hash = state_hash();
      candidate_ = hash == last_hash_;
      last_hash_ = hash;
      wait_steps_ = candidate_ ? 0 : interval_steps_;
      if (!candidate_) return false;
    }
    return reads_sensors ? !proven_with_sensors_ : !proven_without_;
  }
  /// `expected`: bytes of the state before the step with its clocks advanced; `now`: after it.
  void prove(bool reads_sensors, const std::string& expected, const std::string& now);

 private:
  static constexpr std::uint64_t kFirstInterval = 100, kLongestInterval = 3200;

  bool candidate_ = false;  ///< bodies and joints have not moved for an interval
  bool proven_with_sensors_ = false, proven_without_ = false;
  std::uint64_t last_hash_ = 0;
  std::uint64_t interval_steps_ = kFirstInterval;
  std::uint64_t wait_steps_ = kFirstInterval;
};

}  // namespace aprsim::world
