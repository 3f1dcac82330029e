#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace aprsim::render {

/// Patterns that a surface carries in the x-y plane of its mesh.
enum class Pattern : std::uint8_t {
  kPlain,
  kMarker,  ///< an ArUco marker about the mesh's origin of patterns
  kHoles,   ///< threaded holes of an optical table, 1 inch apart
  kBelt,    ///< stripes across x, moved by the instance's phase
  kGrid,    ///< lines of a floor, 1 m apart
};

/// How a surface reflects light. Colours are linear shares of the incoming light.
struct Material {
  Eigen::Vector3f colour = Eigen::Vector3f::Constant(0.5F);
  Eigen::Vector3f second = Eigen::Vector3f::Zero();  ///< of the pattern: ink, holes, stripes, lines
  float gloss = 0;                                   ///< share reflected as by a mirror, blurred
  Pattern pattern = Pattern::kPlain;
  int marker = 0;                                           ///< number in the dictionary
  Eigen::Vector2f marker_centre = Eigen::Vector2f::Zero();  ///< [m]
  float marker_size_m = 0;                                  ///< of the black square
};

/// Linear colour of an sRGB code such as 0xff8000.
[[nodiscard]] Eigen::Vector3f linear_colour(std::uint32_t srgb);

}  // namespace aprsim::render
