#pragma once

#include <string>

#include "world/api/description/cell_description.hpp"
#include "world/api/snapshot/vision.hpp"

namespace aprsim::vision_server {

/// One frame as APRS vision clients read it: `name,rotation,x,y,score,type,` for each object, all
/// on one line that ends in a line feed. Names are type names and repeat; rotation in radians, x
/// and y in millimetres; types are P (part), PT (part tray) and KT (kit tray). With `empty_slots`,
/// each body of the cell that was not detected follows as `name,,,,,type,`, as the lab's cameras
/// report undetected parts.
[[nodiscard]] std::string vision_line(const api::VisionFrame& frame,
                                      const api::CellDescription& cell, bool empty_slots);

}  // namespace aprsim::vision_server
