#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace aprsim::robot {

/// Slows a path down in places. A profile with speed and acceleration limits runs along a stretched
/// parameter rho; this maps it to the path parameter u in [0, 1] with a rate du/drho <= 1 that
/// falls where the path demands it. The rate and its change per rho are continuous and bounded.
/// Built when a motion is planned; evaluation never allocates. A copyable value. Thread: sim.
class TimeScaling {
 public:
  /// What the path allows at one u.
  struct Knot {
    double u = 0;
    double rate = 1;   ///< highest du/drho, in (0, 1]
    double slope = 0;  ///< highest |d(rate)/drho|, > 0
  };

  void reserve(std::size_t knots);
  /// No slowing: rho == u.
  void clear();
  /// `knots` with u rising from 0 to 1. The rates chosen are the highest that keep every bound;
  /// with a `window` > 0 the slope then changes over a rho of that length, never at once, and rates
  /// are lower by what that takes.
  void build(std::span<const Knot> knots, double window = 0);

  [[nodiscard]] double length() const { return length_; }  ///< rho at u == 1
  [[nodiscard]] double u_at(double rho) const;
  [[nodiscard]] double rate_at(double rho) const;
  [[nodiscard]] double rate_of(double u) const;
  [[nodiscard]] bool stretched() const { return !cells_.empty(); }

 private:
  /// From one knot to the next: u = u0 + rate0 r + slope0 r^2 / 2 + curve r^3 / 6, r = rho - rho0.
  struct Cell {
    double rho = 0, u = 0, rate = 0, slope = 0, curve = 0;
  };
  [[nodiscard]] const Cell& cell_at(double rho) const;
  void smooth(double window);
  void lay_cells(double step);

  std::vector<Cell> cells_;
  std::vector<double> rates_, work_;  ///< while smoothing
  double length_ = 1;
};

}  // namespace aprsim::robot
