#pragma once

#include <algorithm>
#include <cmath>

/// Triangle of upper arm, forearm and the line from shoulder to wrist.
namespace aprsim::robot {

inline constexpr double kReachTolerance = 1e-10;  ///< beyond reach by less counts as stretched [m]

/// The other leg of a right triangle; 0 where rounding has made the hypotenuse the shorter one.
[[nodiscard]] inline double leg(double hypotenuse, double first) {
  return std::sqrt(std::max(0.0, (hypotenuse - first) * (hypotenuse + first)));
}

struct TwoBone {
  double excess_m = 0;  ///< > 0: wrist too far; < 0: too near; else within reach
  double limit_m = 0;   ///< that it exceeds
  double bend_rad = 0;  ///< 0 = stretched .. pi = folded
};

/// `distance_m` from shoulder to wrist. Half-angle form of the law of cosines: exact also for a
/// nearly stretched arm, where the usual form loses half the digits.
[[nodiscard]] inline TwoBone solve_two_bone(double upper_m, double fore_m, double distance_m) {
  const double longest = upper_m + fore_m;
  const double shortest = std::abs(upper_m - fore_m);
  if (distance_m > longest + kReachTolerance)
    return {.excess_m = distance_m - longest, .limit_m = longest};
  if (distance_m < shortest - kReachTolerance)
    return {.excess_m = distance_m - shortest, .limit_m = shortest};
  const double d = std::clamp(distance_m, shortest, longest);
  return {.bend_rad = 2 * std::atan2(std::sqrt((longest - d) * (longest + d)),
                                     std::sqrt((d - shortest) * (d + shortest)))};
}

}  // namespace aprsim::robot
