#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace aprsim::robot {

/// Slows a path down in places. A profile with speed and acceleration limits runs along a stretched
/// parameter rho; this maps it to the path parameter u in [0, 1] with a rate du/drho <= 1 that
/// falls where the path demands it. The rate is continuous; its change per rho is bounded.
/// Built when a motion is planned; evaluation never allocates. Thread: sim.
class PathStretch {
 public:
  /// What the path allows at one u.
  struct Knot {
    double u = 0;
    double rate = 1;   ///< highest du/drho, in (0, 1]
    double slope = 0;  ///< highest |d(rate)/drho|, > 0
  };

  void reserve(std::size_t knots) { cells_.reserve(knots); }
  /// No slowing: rho == u.
  void clear();
  /// `knots` with u rising from 0 to 1. The rates chosen are the highest that keep every bound.
  void build(std::span<const Knot> knots);

  [[nodiscard]] double length() const { return length_; }  ///< rho at u == 1
  [[nodiscard]] double u_at(double rho) const;
  [[nodiscard]] double rate_at(double rho) const;
  [[nodiscard]] double rate_of(double u) const;
  [[nodiscard]] bool stretched() const { return !cells_.empty(); }

 private:
  /// Between two knots: u = u0 + rate0 r + slope r^2 / 2 with r = rho - rho0.
  struct Cell {
    double rho = 0, u = 0, rate = 0, slope = 0;
  };
  [[nodiscard]] const Cell& cell_at(double rho) const;

  std::vector<Cell> cells_;
  double length_ = 1;
};

}  // namespace aprsim::robot
