#pragma once

#include "world/render/mesh/material.hpp"

/// Surfaces of the cell. Trays are dark and tables bright, as in the laboratory, so that vision by
/// brightness works on the pictures.
namespace aprsim::render {

[[nodiscard]] inline Material paint(std::uint32_t srgb, float gloss = 0.04F) {
  return {.colour = linear_colour(srgb), .gloss = gloss};
}

inline constexpr std::uint32_t kTrayColour = 0x1d1f22;
inline constexpr std::uint32_t kPocketColour = 0x131416;
inline constexpr std::uint32_t kSteelColour = 0xb4b8bd;
inline constexpr std::uint32_t kTableColour = 0xe4e3de;
/// Brighter than the threshold of the laboratory's detection at exposures that keep hues of gears.
inline constexpr std::uint32_t kOpticalTableColour = 0xd4d7da;
inline constexpr std::uint32_t kDarkColour = 0x2b3037;
/// Colours by size of the gear, the largest first. Their hues are those that the laboratory's
/// detection of gears accepts: yellow to green.
inline constexpr std::uint32_t kGearColours[] = {0x2f9e3f, 0xf08a24, 0xf2c81c, 0xd64550, 0x18a35c};

/// Colours of parts by the number of their type, and of fixtures.
inline constexpr std::uint32_t kPartColours[] = {0x3f7fd0, 0xc8ccd2, 0xb5533c, 0xd9a441,
                                                 0x5b8f6b, 0x7a5ea8, 0x4a5058};
inline constexpr std::uint32_t kFixtureColour = 0x7d8793;

}  // namespace aprsim::render
