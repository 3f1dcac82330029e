#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <google/protobuf/duration.pb.h>

#include "aprsim/v1/geometry.pb.h"
#include "clients/wires/cell_connection.hpp"

/// The cell as ROS 2's simulation_interfaces 2.1 sees it: robots and bodies are entities.
namespace aprsim::ros2 {

/// Codes of simulation_interfaces/msg/Result that several services have.
enum ResultCode : std::uint8_t {
  kUnsupported = 0,
  kOk = 1,
  kNotFound = 2,
  kIncorrectState = 3,
  kFailed = 4,
};

/// simulation_interfaces/msg/Result. Codes beyond ResultCode are those of single services.
struct SimulationResult {
  std::uint8_t code = kOk;
  std::string message;
};

/// States of simulation_interfaces/msg/SimulationState that the cell has.
enum SimulationState : std::uint8_t { kStateStopped = 0, kStatePlaying = 1, kStatePaused = 2 };

/// simulation_interfaces/msg/EntityState, in the world: m, m/s, rad/s.
struct EntityState {
  google::protobuf::Duration stamp;
  v1::Pose pose;
  v1::Vector3 linear, angular;
};

/// A robot or a body.
struct Entity {
  std::string name;
  std::uint8_t category = 0;  ///< of simulation_interfaces/msg/EntityCategory
  std::string description;    ///< its type
  EntityState state;
};

/// simulation_interfaces/msg/EntityFilters.
struct EntityFilter {
  std::string pattern;  ///< POSIX extended regular expression; empty = all
  std::vector<std::uint8_t> categories;
  bool has_tags = false;
  std::uint8_t bounds = 0;  ///< type; 0 = none
};

/// The request of simulation_interfaces/srv/SetEntityState.
struct StateChange {
  std::string entity;
  EntityState state;
  bool set_pose = false, set_twist = false, set_acceleration = false;
};

/// The request of simulation_interfaces/srv/SpawnEntity.
struct SpawnRequest {
  std::string name;
  bool allow_renaming = false;
  std::string uri, resource_string;  ///< the uri is a type of bodies
  std::string entity_namespace;
  std::string frame;
  v1::Pose pose;
};

struct FoundEntities {
  SimulationResult result;
  std::vector<Entity> entities;
};

/// Serves requests by the daemon, each call blocking; steps end when cancelled. Thread: one.
class Simulation {
 public:
  Simulation(const client::Endpoints& daemon, client::Cancelled cancelled)
      : cell_(daemon), cancelled_(std::move(cancelled)) {}

  /// Numbers of simulation_interfaces/msg/SimulatorFeatures.
  [[nodiscard]] static std::vector<std::uint16_t> features();

  [[nodiscard]] SimulationResult read_state(std::uint8_t& state);
  [[nodiscard]] SimulationResult set_state(std::uint8_t state);
  [[nodiscard]] SimulationResult step(std::uint64_t steps);
  [[nodiscard]] SimulationResult reset(std::uint8_t scope);
  [[nodiscard]] FoundEntities find(const EntityFilter& filter);
  /// One entity, or kNotFound.
  [[nodiscard]] FoundEntities find(const std::string& name);
  [[nodiscard]] SimulationResult set_entity_state(const StateChange& change);
  /// `name`: what the entity is called in the end.
  [[nodiscard]] SimulationResult spawn(const SpawnRequest& request, std::string& name);
  [[nodiscard]] SimulationResult remove(const std::string& name);
  /// Types of bodies that can be spawned.
  [[nodiscard]] SimulationResult read_spawnables(std::vector<std::string>& types);

 private:
  /// Where set_state() stopped the cell.
  struct Stop {
    std::uint64_t epoch = 0, step = 0;
  };
  [[nodiscard]] bool is_stopped(const v1::Snapshot& snapshot) const;

  client::CellConnection cell_;
  client::Cancelled cancelled_;
  std::optional<Stop> stop_;
};

}  // namespace aprsim::ros2
