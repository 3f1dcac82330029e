#include "clients/ros2/simulation/simulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <regex.h>
#include <set>

#include <fmt/format.h>

namespace aprsim::ros2 {
namespace {

// simulation_interfaces/msg/EntityCategory
constexpr std::uint8_t kRobot = 1, kDynamicObject = 4;
// simulation_interfaces/srv/ResetSimulation
constexpr std::uint8_t kScopeDefault = 0, kScopeEverything = 7;
// simulation_interfaces/srv/SetSimulationState
constexpr std::uint8_t kAlreadyInState = 101;
// simulation_interfaces/srv/SetEntityState
constexpr std::uint8_t kInvalidEntityPose = 101;
// simulation_interfaces/srv/SpawnEntity
constexpr std::uint8_t kNameNotUnique = 101, kNameInvalid = 102, kUnsupportedFormat = 103,
                       kNoResource = 104, kNamespaceInvalid = 105, kInvalidSpawnPose = 109;

constexpr std::size_t kMostPattern = 256;
constexpr int kMostRenames = 1000;

SimulationResult failure_of(const client::Failure& failure) { return {kFailed, failure.message}; }

template <typename T>
SimulationResult result_of(const client::Outcome<T>& outcome) {
  return outcome ? SimulationResult{} : failure_of(outcome.error());
}

bool is_finite(const v1::Vector3& v) {
  return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z());
}

bool is_zero(const v1::Vector3& v) { return v.x() == 0 && v.y() == 0 && v.z() == 0; }

/// Why a pose is none; empty = it is one.
std::string pose_error(const v1::Pose& pose) {
  if (!is_finite(pose.position_m())) return "pose.position: found a number that is not finite";
  const auto& q = pose.orientation();
  const double norm = std::sqrt(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z());
  if (std::abs(norm - 1) < 1e-3) return {};
  return fmt::format("pose.orientation: found a quaternion of norm {}, expected 1", norm);
}

std::vector<Entity> entities_of(const v1::CellDescription& cell, const v1::Snapshot& snapshot) {
  std::vector<Entity> entities;
  for (const auto& robot : cell.robots()) {
    entities.push_back({robot.name(),
                        kRobot,
                        robot.model(),
                        {snapshot.sim_time(), robot.base_in_world(), {}, {}}});
  }
  for (const auto& body : snapshot.bodies()) {
    if (body.has_lost_step()) continue;
    entities.push_back({body.name(),
                        kDynamicObject,
                        body.type(),
                        {snapshot.sim_time(), body.body_in_world(), body.velocity_m_s(),
                         body.angular_velocity_rad_s()}});
  }
  return entities;
}

/// A POSIX extended regular expression.
class Pattern {
 public:
  /// `error`: not empty if the text is none.
  Pattern(const std::string& text, std::string& error) {
    if (text.size() > kMostPattern) {
      error = fmt::format("filters.filter: found {} characters, expected at most {}", text.size(),
                          kMostPattern);
      return;
    }
    const int code = regcomp(&pattern_, text.c_str(), REG_EXTENDED | REG_NOSUB);
    is_compiled_ = code == 0;
    if (is_compiled_) return;
    char words[128];
    regerror(code, &pattern_, words, sizeof words);
    error = fmt::format("filters.filter: found \"{}\": {}", text, words);
  }
  ~Pattern() {
    if (is_compiled_) regfree(&pattern_);
  }
  Pattern(const Pattern&) = delete;
  Pattern& operator=(const Pattern&) = delete;

  [[nodiscard]] bool matches(const std::string& name) const {
    return regexec(&pattern_, name.c_str(), 0, nullptr, 0) == 0;
  }

 private:
  regex_t pattern_{};
  bool is_compiled_ = false;
};

SimulationResult check(const SpawnRequest& request, const v1::CellDescription& cell) {
  if (!request.entity_namespace.empty()) {
    return {kNamespaceInvalid,
            fmt::format("entity_namespace: found \"{}\", expected none", request.entity_namespace)};
  }
  if (!request.resource_string.empty()) {
    return {kUnsupportedFormat, "entity_resource.resource_string: found a text, expected none"};
  }
  if (std::ranges::find(cell.body_types(), request.uri) == cell.body_types().end()) {
    return {
        kNoResource,
        fmt::format("entity_resource.uri: found \"{}\", which is no type of bodies", request.uri)};
  }
  if (!request.frame.empty() && request.frame != "world") {
    return {kInvalidSpawnPose, fmt::format("initial_pose.header.frame_id: found \"{}\", expected "
                                           "world",
                                           request.frame)};
  }
  if (auto error = pose_error(request.pose); !error.empty()) return {kInvalidSpawnPose, error};
  return {};
}

/// The name of a new entity; empty = there is none, for the reason in `result`.
std::string new_name(const SpawnRequest& request, const v1::Snapshot& snapshot,
                     SimulationResult& result) {
  std::set<std::string> used;
  for (const auto& body : snapshot.bodies()) used.insert(body.name());
  for (const auto& robot : snapshot.robots()) used.insert(robot.name());
  const std::string& asked = request.name.empty() ? request.uri : request.name;
  if (request.name.empty() && !request.allow_renaming) {
    result = {kNameInvalid, "name: found an empty name, expected one unless it may be renamed"};
    return {};
  }
  if (!request.name.empty() && !used.contains(asked)) return asked;
  for (int i = 1; request.allow_renaming && i <= kMostRenames; ++i) {
    const std::string name = fmt::format("{}_{}", asked, i);
    if (!used.contains(name)) return name;
  }
  result = {kNameNotUnique, fmt::format("name: found \"{}\", which is in use", asked)};
  return {};
}

}  // namespace

std::vector<std::uint16_t> Simulation::features() {
  return {
      0,   // SPAWNING
      1,   // DELETING
      8,   // ENTITY_CATEGORIES
      10,  // ENTITY_STATE_GETTING
      11,  // ENTITY_STATE_SETTING
      12,  // ENTITY_INFO_GETTING
      14,  // SPAWNABLES
      20,  // SIMULATION_RESET
      24,  // SIMULATION_STATE_GETTING
      25,  // SIMULATION_STATE_SETTING
      26,  // SIMULATION_STATE_PAUSE
      31,  // STEP_SIMULATION_SINGLE
      32,  // STEP_SIMULATION_MULTIPLE
      33,  // STEP_SIMULATION_ACTION
  };
}

bool Simulation::is_stopped(const v1::Snapshot& snapshot) const {
  return stop_ && snapshot.paused() && snapshot.epoch() == stop_->epoch &&
         snapshot.step() == stop_->step;
}

SimulationResult Simulation::read_state(std::uint8_t& state) {
  const auto snapshot = cell_.snapshot();
  if (!snapshot) return failure_of(snapshot.error());
  state = is_stopped(*snapshot) ? kStateStopped : snapshot->paused() ? kStatePaused : kStatePlaying;
  return {};
}

SimulationResult Simulation::set_state(std::uint8_t state) {
  std::uint8_t present = 0;
  if (auto read = read_state(present); read.code != kOk) return read;
  if (state == present) return {kAlreadyInState, "the simulation is in this state already"};
  if (state > kStatePaused) {
    return {kUnsupported, fmt::format("state: found {}, expected stopped (0), playing (1) or "
                                      "paused (2)",
                                      state)};
  }
  if (state == kStatePlaying) return result_of(cell_.resume());
  if (auto paused = cell_.pause(); !paused) return failure_of(paused.error());
  stop_.reset();
  if (state == kStatePaused) return {};
  const auto reset = cell_.reset(std::optional<std::uint64_t>{});
  if (!reset) return failure_of(reset.error());
  stop_ = Stop{reset->epoch(), reset->step()};
  return {};
}

SimulationResult Simulation::step(std::uint64_t steps) {
  if (steps == 0) return {kFailed, "steps: found 0, expected at least 1"};
  constexpr std::array kFields{"step"};
  const auto done = cell_.step_and_read(steps, kFields, cancelled_);
  if (done && !*done) return {kFailed, "the steps were cancelled"};
  return result_of(done);
}

SimulationResult Simulation::reset(std::uint8_t scope) {
  if (scope != kScopeDefault && (scope & kScopeEverything) != kScopeEverything) {
    return {
        kUnsupported,
        fmt::format("scope: found {}, expected all (0 or 255): time, poses and bodies are reset "
                    "together",
                    scope)};
  }
  return result_of(cell_.reset(std::optional<std::uint64_t>{}));
}

FoundEntities Simulation::find(const EntityFilter& filter) {
  if (filter.has_tags || filter.bounds != 0) {
    return {{kUnsupported, "filters: found tags or bounds, expected a filter or categories"}, {}};
  }
  std::string error;
  const Pattern pattern(filter.pattern, error);
  if (!error.empty()) return {{kFailed, error}, {}};
  const auto cell = cell_.cell();
  const auto snapshot = cell_.snapshot();
  if (!cell) return {failure_of(cell.error()), {}};
  if (!snapshot) return {failure_of(snapshot.error()), {}};
  FoundEntities found{{}, entities_of(*cell, *snapshot)};
  std::erase_if(found.entities, [&](const Entity& entity) {
    const bool is_of_category =
        filter.categories.empty() ||
        std::ranges::find(filter.categories, entity.category) != filter.categories.end();
    return !is_of_category || !pattern.matches(entity.name);
  });
  return found;
}

FoundEntities Simulation::find(const std::string& name) {
  auto found = find(EntityFilter{});
  std::erase_if(found.entities, [&](const Entity& entity) { return entity.name != name; });
  if (found.result.code == kOk && found.entities.empty()) {
    found.result = {kNotFound, fmt::format("entity: found \"{}\", which is not in the cell", name)};
  }
  return found;
}

SimulationResult Simulation::set_entity_state(const StateChange& change) {
  const auto found = find(change.entity);
  if (found.result.code != kOk) return found.result;
  if (found.entities.front().category == kRobot) {
    return {kUnsupported,
            fmt::format("entity: found {}, a robot, which stays in its place", change.entity)};
  }
  const auto& state = change.state;
  if (change.set_twist && !(is_zero(state.linear) && is_zero(state.angular))) {
    return {kUnsupported, "state.twist: found a velocity, expected 0: bodies are placed at rest"};
  }
  if (change.set_acceleration) {
    return {kUnsupported, "set_acceleration: found true, expected false"};
  }
  if (!change.set_pose) {
    return {kUnsupported, "set_pose: found false, expected true: a change of pose ends all motion"};
  }
  if (auto error = pose_error(state.pose); !error.empty()) return {kInvalidEntityPose, error};
  v1::MoveBodyRequest request;
  request.set_name(change.entity);
  *request.mutable_body_in_world() = state.pose;
  return result_of(cell_.move_body(request));
}

SimulationResult Simulation::spawn(const SpawnRequest& request, std::string& name) {
  const auto cell = cell_.cell();
  const auto snapshot = cell_.snapshot();
  if (!cell) return failure_of(cell.error());
  if (!snapshot) return failure_of(snapshot.error());
  SimulationResult result = check(request, *cell);
  if (result.code != kOk) return result;
  name = new_name(request, *snapshot, result);
  if (name.empty()) return result;
  v1::SpawnBodyRequest spawn;
  spawn.set_type(request.uri);
  spawn.set_name(name);
  *spawn.mutable_body_in_world() = request.pose;
  const auto spawned = cell_.spawn_body(spawn);
  if (!spawned) name.clear();
  return result_of(spawned);
}

SimulationResult Simulation::remove(const std::string& name) {
  const auto found = find(name);
  if (found.result.code != kOk) return found.result;
  if (found.entities.front().category == kRobot) {
    return {kFailed, fmt::format("entity: found {}, a robot, which stays in the cell", name)};
  }
  return result_of(cell_.remove_body(name));
}

SimulationResult Simulation::read_spawnables(std::vector<std::string>& types) {
  const auto cell = cell_.cell();
  if (!cell) return failure_of(cell.error());
  types.assign(cell->body_types().begin(), cell->body_types().end());
  return {};
}

}  // namespace aprsim::ros2
