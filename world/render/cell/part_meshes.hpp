#pragma once

#include <map>
#include <optional>
#include <string>

#include "world/render/mesh/mesh.hpp"
#include "world/scene/model/parts.hpp"

namespace aprsim::render {

/// A gear with its teeth. Disc, peg and hub have the sizes of the scene's type.
[[nodiscard]] Mesh gear_mesh(const scene::GearType& type, std::uint32_t colour);

/// Outline of the disc with its teeth, anticlockwise.
[[nodiscard]] Outline toothed_outline(double tip_radius_m);

/// A label in a square recess of a tray's top face.
struct Label {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< in the tray's frame [m]
  double size_m = 0;                                 ///< of the recess, and of the white square
  double depth_m = 0;                                ///< of the recess
  int marker = 0;
};
/// Depth of the recess where the type of the tray has none [m].
inline constexpr double kLabelDepth_m = 1e-3;
/// Black square of the marker, as a share of the label.
inline constexpr double kMarkerShare = 0.75;

/// The label of a tray: where its type has a recess for it; else 40 mm about the frame's origin, or
/// the next smaller size and nearest place where it meets no pocket, and no gear in one hides it;
/// nullopt where there is none.
[[nodiscard]] std::optional<Label> place_label(const scene::TrayType& type,
                                               const std::map<std::string, scene::GearType>& gears,
                                               int marker);

/// A tray with its pockets and its label.
[[nodiscard]] Mesh tray_mesh(const scene::TrayType& type, const std::optional<Label>& label);

/// Number of a tray's marker: the digits at the end of its name, modulo the dictionary's size.
[[nodiscard]] int marker_of(const std::string& tray);

}  // namespace aprsim::render
