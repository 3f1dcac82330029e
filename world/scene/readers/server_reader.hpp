#pragma once

#include <cstddef>
#include <optional>

#include "world/base/yaml/yaml_reader.hpp"
#include "world/scene/model/servers.hpp"

namespace aprsim::scene {

/// The key servers of a robot with this number of joints: a map with simple_message, a map:
///
///   controller        fanuc_karel (six joints) or motoman_fs100 (seven joints)
///   motion, state, gripper   ports; absent: those of the real controller
///   joint_speed       of the Fanuc's moves, share of the joints' speeds
///   cnt               of the Fanuc's moves, 0 to 100
///   interpolation_ms  period of the Motoman's increments
[[nodiscard]] std::optional<SimpleMessageServers> read_servers(const yaml::Node& node,
                                                               std::size_t joint_count);

}  // namespace aprsim::scene
