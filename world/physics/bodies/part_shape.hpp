#pragma once

#include <vector>

#include "world/physics/collision/shapes/convex_piece.hpp"
#include "world/scene/model/parts.hpp"

namespace aprsim::physics {

/// The shape of a part, prepared for contact generation. Parts of one type share it.
struct PartShape {
  explicit PartShape(const scene::PartType& type);

  std::vector<ConvexPiece> pieces;
  int material = 0;  ///< see MaterialTable
};

}  // namespace aprsim::physics
