#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace aprsim::bench {

/// How friction held a load that grew through its limit: 0.9, 0.98, 1.02 of the closed form's.
struct Verdict {
  double onset = 0;            ///< the load at which slip began, over the closed form's
  double creep_m_s = 0;        ///< at 0.9 of the limit
  bool false_drop = false;     ///< slipped at 0.98
  bool false_hold = false;     ///< did not slip at 1.02, or by less than half of what it should
  std::uint64_t unsolved = 0;  ///< steps in which the solver missed its tolerance
};

inline constexpr double kStep = 1e-3;  ///< of all these scenes [s]
inline constexpr double kCreepShare = 0.9, kBelowShare = 0.98, kAboveShare = 1.02;
inline constexpr double kNoSlip = 1e-6;  ///< less than this is none [m]

}  // namespace aprsim::bench
