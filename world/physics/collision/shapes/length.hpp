#pragma once

#include <cmath>

namespace aprsim::physics {

/// Length of a vector in a plane. It is faster than std::hypot, which also protects from overflow.
inline double length(double x, double y) { return std::sqrt(x * x + y * y); }

}  // namespace aprsim::physics
