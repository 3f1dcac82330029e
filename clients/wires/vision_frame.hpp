#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "clients/wires/outcome.hpp"

namespace aprsim::client {

/// One object of a camera's frame, in the vision frame V of the camera's robot.
struct VisionObject {
  std::string name;       ///< type of the object, e.g. sku_part_large_gear; repeats
  std::string kind;       ///< P = part, PT = part tray, KT = kit tray
  bool detected = false;  ///< false: named, but not seen; all that follows is 0 then
  double rotation_rad = 0;
  double x_m = 0, y_m = 0;
  double score = 0;  ///< confidence, 0 to 1
};

/// Decodes one line of a camera's feed: `name,rotation,x,y,score,kind,` for each object, rotation
/// in radians, x and y in millimetres. Blanks may follow a comma. An object with an empty number
/// counts as not detected. Failures: kConnection, for anything else.
[[nodiscard]] Outcome<std::vector<VisionObject>> decode_vision_line(std::string_view line);

}  // namespace aprsim::client
