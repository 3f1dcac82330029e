#pragma once

#include <algorithm>
#include <aprsim_ros2_messages.h>
#include <iterator>

#include "clients/ros2/actions/goal_table.hpp"

/// Identifiers of goals as CycloneDDS has them in C.
namespace aprsim::ros2 {

inline GoalId id_of(const unique_identifier_msgs_msg_dds__UUID_& uuid) {
  GoalId id;
  std::copy(std::begin(uuid.uuid), std::end(uuid.uuid), id.begin());
  return id;
}

inline unique_identifier_msgs_msg_dds__UUID_ uuid_of(const GoalId& id) {
  unique_identifier_msgs_msg_dds__UUID_ uuid{};
  std::ranges::copy(id, std::begin(uuid.uuid));
  return uuid;
}

}  // namespace aprsim::ros2
