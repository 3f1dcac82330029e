#pragma once

#include <array>

#include "world/scene/checks/overlap.hpp"
#include "world/scene/model/scene.hpp"

/// The solids that a scene's objects consist of.
namespace aprsim::scene {

[[nodiscard]] Solid solid_of(const StaticBox& box);
/// The belt, as a plate of 1 mm under its top face.
[[nodiscard]] Solid solid_of(const Conveyor& conveyor);
/// The slab without its pockets.
[[nodiscard]] Solid solid_of(const TrayType& type, const Pose& X_WP);
/// Disc, peg and hub.
[[nodiscard]] std::array<Solid, 3> solids_of(const GearType& type, const Pose& X_WP);

/// `X_WP`: frame of the part or fixture.
[[nodiscard]] Solid solid_of(const api::Piece& piece, const Pose& X_WP);

/// Whether the piece, as far as it lies under the tray's top face, lies in one pocket.
[[nodiscard]] bool lies_in_pocket(const api::Piece& piece, const Pose& X_WB, const TrayType& tray,
                                  const Pose& X_WP);

}  // namespace aprsim::scene
