#include "world/physics/collision/shapes/gear_shape.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::physics::detail {
namespace {

/// Frustum between two heights with a radius at each.
Piece& add_piece(GearShape& shape, double z0, double r0, double z1, double r1) {
  Piece& p = shape.pieces[static_cast<std::size_t>(shape.piece_count++)];
  p.z0 = z0;
  p.r0 = r0;
  p.z1 = z1;
  p.r1 = r1;
  // Cylinders keep slope 0 and cosine 1 exactly.
  if (r1 != r0) {
    p.slope = (r1 - r0) / (z1 - z0);
    p.cosine = 1 / std::sqrt(1 + p.slope * p.slope);
  }
  shape.z_low = std::min(shape.z_low, z0);
  shape.z_high = std::max(shape.z_high, z1);
  shape.r_max = std::max({shape.r_max, r0, r1});
  return p;
}

void add_ring(GearShape& shape, double z, double r) {
  shape.rings[static_cast<std::size_t>(shape.ring_count++)] = {z, r, shape.piece_count - 1};
}

/// The hub's cone below the disc, cut off by its chamfer.
void add_hub(GearShape& shape, const scene::GearType& gear) {
  const double h = gear.hub_height_m, c = std::min(gear.hub_chamfer_m, h);
  // The chamfer is at 45 degrees: its height c equals its width.
  const double slope = (gear.hub_top_radius_m - gear.hub_bottom_radius_m) / h;
  const double r_edge = gear.hub_bottom_radius_m + slope * c;
  if (c < h) {
    Piece& hub = add_piece(shape, c - h, r_edge, 0, gear.hub_top_radius_m);
    // Glued to the disc above it, and below to its chamfer, if it has one.
    hub.low_exposed = c <= 0;
    hub.z_out_low = -h;
    hub.high_reach = kGluedReach;
    add_ring(shape, c - h, r_edge);
  }
  if (c > 0) {
    const double r_bottom = std::max(0.0, r_edge - c);
    Piece& chamfer = add_piece(shape, -h, r_bottom, c - h, r_edge);
    chamfer.low_exposed = true;
    chamfer.z_out_low = -h;
    add_ring(shape, -h, r_bottom);
  }
}

}  // namespace

GearShape::GearShape(const scene::GearType& gear) : r_peg(gear.peg_radius_m) {
  // Disc from z = 0 up, hub below it, peg on top of it.
  Piece& disc = add_piece(*this, 0, gear.disc_radius_m, gear.disc_height_m, gear.disc_radius_m);
  disc.low_exposed = disc.high_exposed = true;
  disc.z_out_low = 0;
  disc.z_out_high = gear.disc_height_m;
  add_ring(*this, 0, gear.disc_radius_m);
  add_ring(*this, gear.disc_height_m, gear.disc_radius_m);
  if (gear.hub_height_m > 0) add_hub(*this, gear);
  if (gear.peg_top_m > gear.disc_height_m && gear.peg_radius_m > 0) {
    Piece& peg =
        add_piece(*this, gear.disc_height_m, gear.peg_radius_m, gear.peg_top_m, gear.peg_radius_m);
    peg.high_exposed = true;
    peg.z_out_high = gear.peg_top_m;
    peg.low_reach = kGluedReach;
    add_ring(*this, gear.peg_top_m, gear.peg_radius_m);
  }
}

GearShape frustum_shape(double z_low, double r_low, double z_high, double r_high) {
  GearShape shape;
  shape.z_low = z_low;
  shape.z_high = z_high;
  Piece& piece = add_piece(shape, z_low, r_low, z_high, r_high);
  piece.low_exposed = piece.high_exposed = true;
  piece.z_out_low = z_low;
  piece.z_out_high = z_high;
  add_ring(shape, z_low, r_low);
  add_ring(shape, z_high, r_high);
  // A pad's groove is as deep as for a peg of the wider end.
  shape.r_peg = shape.r_max;
  return shape;
}

}  // namespace aprsim::physics::detail
