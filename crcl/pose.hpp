#pragma once

#include "crcl/error.hpp"
#include "crcl/values.hpp"

namespace aprsim::crcl {

/// A right-handed orthonormal triad: the columns of the rotation that a pose's axes stand for.
struct Axes {
  Vector x, y, z;
};

/// The triad of a pose: ZAxis normalised, XAxis made perpendicular to it and normalised, Y = Z x X.
/// Writers round their axes (0.707), so lengths and right angles need not be exact. An axis without
/// length, or axes closer to parallel than about 6 degrees, give no orientation: kBadValue.
[[nodiscard]] Result<Axes> orthonormal_axes(const Pose& pose);

}  // namespace aprsim::crcl
