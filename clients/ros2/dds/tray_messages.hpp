#pragma once

#include <vector>

#include <google/protobuf/duration.pb.h>

#include "clients/ros2/dds/node.hpp"
#include "clients/ros2/trays/tray_finder.hpp"

/// Messages of NIST's aprs_interfaces. Errors of DDS: std::runtime_error.
namespace aprsim::ros2 {

/// aprs_interfaces/msg/Trays.
[[nodiscard]] TopicType trays_type();

/// Trays in the world, slots in the frames of their trays. `time`: simulated, of the poses.
void write_trays(dds_entity_t writer, const google::protobuf::Duration& time,
                 const std::vector<SeenTray>& trays);

}  // namespace aprsim::ros2
