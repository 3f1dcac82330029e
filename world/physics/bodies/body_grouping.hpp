#pragma once

namespace aprsim::physics {

/// Grouping of a body by contact simplification; -1 = none.
struct BodyGrouping {
  int carrier = -1;   ///< the body that it is merged with
  int sleeping = -1;  ///< lowest body of its sleeping group
  int joined = -1;    ///< lowest body of those that virtual joints tie it to

  bool operator==(const BodyGrouping&) const = default;
};

}  // namespace aprsim::physics
