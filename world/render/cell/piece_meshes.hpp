#pragma once

#include <cstdint>
#include <span>

#include "world/api/values/piece.hpp"
#include "world/render/mesh/mesh.hpp"

namespace aprsim::render {

/// The pieces of a part or fixture in its frame, with every face.
[[nodiscard]] Mesh pieces_mesh(std::span<const api::Piece> pieces, std::uint32_t colour);

}  // namespace aprsim::render
