#pragma once

#include <array>

namespace aprsim::robot {

/// State of a scalar path parameter; the unit of `s` is the caller's (rad, m, share of a path).
struct ScalarState {
  double s = 0, v = 0, a = 0;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [s, v, a] = self;
    io(s, v, a);
  }
};

/// Magnitudes, all > 0, in the unit of the parameter per s, s^2, s^3.
struct ScalarLimits {
  double v = 0, a = 0, j = 0;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [v, a, j] = self;
    io(v, a, j);
  }
};

/// Jerk-limited ("double-S") motion of a scalar from any state to rest. At most eight phases of
/// constant jerk: a change to a cruise speed, the cruise, a change to rest. A start within the
/// limits never leaves them; a start beyond them returns to them first, at the jerk limit.
/// Evaluation neither allocates nor loops without bound. Thread: any.
class DoubleS {
 public:
  DoubleS() = default;

  /// To rest at `s_end`. Passes beyond it only when `start` is too fast to stop before it.
  [[nodiscard]] static DoubleS to_rest(const ScalarState& start, double s_end,
                                       const ScalarLimits& limits);
  /// To rest as soon as the limits allow, at any position; limits.v is not used.
  [[nodiscard]] static DoubleS stop(const ScalarState& start, const ScalarLimits& limits);

  /// State at `t` seconds after the start; from duration() on exactly {end(), 0, 0}.
  [[nodiscard]] ScalarState at(double t) const;
  [[nodiscard]] double duration() const { return duration_; }
  [[nodiscard]] double end() const { return end_; }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [phases, count, duration, end] = self;
    io(phases, count, duration, end);
    io.require(count >= 0 && count <= kMaxPhases && (count > 0 || duration <= 0),
               "more or fewer phases than a profile has");
  }

 private:
  static constexpr int kMaxPhases = 8;
  struct Phase {
    double begin = 0;  ///< [s]
    double jerk = 0;
    ScalarState state;  ///< at its begin

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [begin, jerk, state] = self;
      io(begin, jerk, state);
    }
  };

  void add(double dt, double jerk, ScalarState& state);
  void change_speed(double v_end, const ScalarLimits& limits, ScalarState& state);

  std::array<Phase, kMaxPhases> phases_{};
  int count_ = 0;
  double duration_ = 0;
  double end_ = 0;
};

}  // namespace aprsim::robot
