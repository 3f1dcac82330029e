#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "world/robot/trajectory/profile/shared_parts.hpp"

namespace aprsim::robot {

/// Slows a path down in places. A profile with constant limits runs along a scaled parameter rho;
/// the time scaling maps it to the path parameter u in [0, 1] with a rate du/drho <= 1 that falls
/// where the path requires it. The rate and its slope d(rate)/drho are continuous and bounded.
/// Built when a motion is planned; evaluation never allocates. A copyable value. Thread: sim.
class TimeScaling {
 public:
  /// Highest rate and slope at one u.
  struct RateLimit {
    double u = 0;
    double rate = 1;   ///< highest du/drho, in (0, 1]
    double slope = 0;  ///< highest |d(rate)/drho|, > 0
  };

  /// The identity: rho == u.
  void clear();
  /// `limits` with u rising from 0 to 1. The rates are the highest within all limits; with a
  /// `window` > 0 they are then smoothed, so that the slope changes over a rho of that length.
  void build(std::span<const RateLimit> limits, double window = 0);

  [[nodiscard]] double length() const { return length_; }  ///< rho at u == 1
  [[nodiscard]] double u_at(double rho) const;
  [[nodiscard]] double rate_at(double rho) const;
  [[nodiscard]] double rate_of(double u) const;
  /// Not the identity.
  [[nodiscard]] bool active() const { return !pieces_.empty(); }
  /// Allocated memory, besides the value itself.
  [[nodiscard]] std::size_t bytes() const {
    return bytes_of(pieces_) + bytes_of(rates_) + bytes_of(work_);
  }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [pieces, rates, work, length] = self;
    io(pieces, length);
  }

 private:
  /// u = u0 + rate0 r + slope0 r^2 / 2 + curvature r^3 / 6 with r = rho - rho0.
  struct Piece {
    double rho = 0, u = 0, rate = 0, slope = 0, curvature = 0;

    template <typename Self, typename Io>
    static void fields(Self& self, Io& io) {
      auto& [rho, u, rate, slope, curvature] = self;
      io(rho, u, rate, slope, curvature);
    }
  };
  [[nodiscard]] const Piece& piece_at(double rho) const;
  void smooth(double window);
  void fit_pieces(double step);

  std::vector<Piece> pieces_;
  std::vector<double> rates_, work_;  ///< while smoothing
  double length_ = 1;
};

}  // namespace aprsim::robot
