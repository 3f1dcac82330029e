#pragma once

#include <vector>

#include "clients/aprsim/demo/cell_view.hpp"

namespace aprsim::client {

/// Height of the tool point over the gear's frame when gripping: the finger tips stay clear of the
/// disc's upper face by this much.
[[nodiscard]] double grasp_height_m(const v1::GearGeometry& gear);

/// Yaws of a tool pointing down at which to take a gear and put it into a slot, best first: open
/// fingers keep clear of the pegs next to both places, then little turning from the present yaw.
[[nodiscard]] std::vector<double> rank_yaws(const CellView& view, const Transfer& transfer,
                                            const v1::GripperDescription& gripper,
                                            double present_yaw_rad);

/// Distance by which the open fingers miss the nearest peg when the tool stands at p_WT with that
/// yaw; negative = they would hit it. Pegs too low to be hit and `ignored` itself do not count.
[[nodiscard]] double finger_clearance_m(const CellView& view, const std::string& ignored,
                                        const v1::GripperDescription& gripper,
                                        const Eigen::Vector3d& p_WT, double yaw_rad);

}  // namespace aprsim::client
