#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "aprsim/v1/cell.pb.h"

namespace aprsim::ros2 {

/// An area whose trays a camera of the laboratory sees.
struct TrayArea {
  std::string topic;        ///< without the namespace: "/fanuc/table_trays_info"
  bool has_frames = false;  ///< trays and slots are frames; else their names may repeat others'
};

/// The area of a camera by its name, as NIST's aprs_vision names them: AREA_table has the topic
/// /AREA/table_trays_info, AREA_conveyor and AREA_belt have /AREA/conveyor_trays_info. Areas of
/// robots have frames. Absent for other names and for cameras on flanges.
[[nodiscard]] std::optional<TrayArea> tray_area_of(const v1::CameraDescription& camera,
                                                   const v1::CellDescription& cell);

/// Number on the label of a tray: the digits at the end of its name, modulo 50.
[[nodiscard]] int label_of(std::string_view tray);

}  // namespace aprsim::ros2
