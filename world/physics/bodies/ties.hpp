#pragma once

namespace aprsim::physics {

/// What contact simplification has tied a body to; -1 = to nothing.
struct Ties {
  int carrier = -1;   ///< the body that it is merged with
  int sleeping = -1;  ///< lowest body of its sleeping group
  int joined = -1;    ///< lowest body of those that virtual joints tie it to

  bool operator==(const Ties&) const = default;
};

}  // namespace aprsim::physics
