#include "world/render/mesh/material.hpp"

#include <cmath>

namespace aprsim::render {
namespace {

/// IEC 61966-2-1.
float linear_share(std::uint32_t code) {
  const double s = code / 255.0;
  return static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
}

}  // namespace

Eigen::Vector3f linear_colour(std::uint32_t srgb) {
  return {linear_share((srgb >> 16U) & 0xffU), linear_share((srgb >> 8U) & 0xffU),
          linear_share(srgb & 0xffU)};
}

}  // namespace aprsim::render
