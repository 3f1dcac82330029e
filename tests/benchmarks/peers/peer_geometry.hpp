#pragma once

#include <vector>

#include <Eigen/Core>

#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

struct PeerBox {
  Eigen::Vector3d centre, half;
  bool floor = false;  ///< lies on the belt; the others carry and guide gears
};
struct PeerCylinder {
  double z_centre = 0, radius = 0, half_height = 0;
};

/// Trays and gears as other engines take them best: primitives only. A pocket is a square hole as
/// wide as the pocket's mouth, a gear its disc and a straight hub; the same clearance as in the
/// scene.

/// Boxes of a tray with pockets in two columns and two rows, in the tray frame. Throws
/// std::invalid_argument for any other tray.
std::vector<PeerBox> tray_boxes(const scene::TrayType& tray);
/// Disc and hub in the gear frame, axis z.
std::vector<PeerCylinder> gear_cylinders(const scene::GearType& gear);

}  // namespace aprsim::bench
