#pragma once

#include <cstdint>

namespace aprsim::render {

/// Number of markers in ArUco's dictionary DICT_5X5_50, and of bits along a side.
inline constexpr int kMarkers = 50, kMarkerBits = 5;
/// With the black border one bit wide.
inline constexpr int kMarkerCells = kMarkerBits + 2;

/// Whether a cell of a marker is white. Rows count down from the top, columns from the left, the
/// border included.
[[nodiscard]] bool marker_is_white(int marker, int row, int column);

}  // namespace aprsim::render
