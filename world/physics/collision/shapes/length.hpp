#pragma once

#include <cmath>

namespace aprsim::physics {

/// Of a vector in a plane, without the care for overflow that costs std::hypot its time.
inline double length(double x, double y) { return std::sqrt(x * x + y * y); }

}  // namespace aprsim::physics
