#include "world/scene/readers/server_reader.hpp"

#include <string>

namespace aprsim::scene {
namespace {

constexpr std::int64_t kMaxPort = 65535;

void read_port(const yaml::Node& node, std::uint16_t& port) {
  if (node) port = static_cast<std::uint16_t>(node.integer(0, kMaxPort));
}

}  // namespace

std::optional<SimpleMessageServers> read_servers(const yaml::Node& node, std::size_t joint_count) {
  if (!node) return std::nullopt;
  const yaml::Node own = node.map({"simple_message"})["simple_message"];
  if (!own) return std::nullopt;
  const yaml::Map keys = own.map(
      {"controller", "motion", "state", "gripper", "joint_speed", "cnt", "interpolation_ms"});
  SimpleMessageServers servers;
  const yaml::Node controller = keys["controller"];
  const bool is_motoman = controller.word({"fanuc_karel", "motoman_fs100"}) == 1;
  if (is_motoman) {
    servers = {.controller = SimpleMessageController::kMotomanFs100,
               .motion_port = 50240,
               .state_port = 50241,
               .gripper_port = 50242};
  } else {
    servers = {.controller = SimpleMessageController::kFanucKarel,
               .motion_port = 11000,
               .state_port = 11002,
               .gripper_port = 12123};
  }
  const std::size_t joints = is_motoman ? 7 : 6;
  if (joint_count != joints) {
    controller.unexpected("the controller of a robot with " + std::to_string(joint_count) +
                          " joints");
  }
  read_port(keys["motion"], servers.motion_port);
  read_port(keys["state"], servers.state_port);
  read_port(keys["gripper"], servers.gripper_port);
  servers.joint_speed = keys["joint_speed"].number_or(servers.joint_speed, yaml::between(0.001, 1));
  servers.cnt = keys["cnt"].number_or(servers.cnt, yaml::between(0, 100));
  if (const yaml::Node clock = keys["interpolation_ms"]) {
    servers.interpolation_ms = static_cast<int>(clock.integer(1, 100));
  }
  return servers;
}

}  // namespace aprsim::scene
