#include "world/cell/world.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <stdexcept>
#include <utility>

#include "world/api/snapshot/snapshot_fields.hpp"
#include "world/archive/archive.hpp"
#include "world/cell/describe_cell.hpp"
#include "world/cell/device_executor.hpp"
#include "world/cell/fault_executor.hpp"
#include "world/cell/machines/describe_robot.hpp"
#include "world/cell/state_bytes.hpp"
#include "world/devices/input_check.hpp"
#include "world/physics/bodies/body_ids.hpp"
#include "world/physics/bodies/physics_failure.hpp"

namespace aprsim::world {
namespace {

// Belt sensors and light curtain are read once in the cycle of an ordinary PLC.
constexpr SimTime kSensorPeriod = std::chrono::milliseconds(10);

/// FNV-1a over the bits of a value.
void mix(std::uint64_t& hash, double value) {
  hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3ULL;
}

/// Copies the state of a part, but no constant of its scene.
template <typename Part>
void copy_state(const Part& from, Part& to) {
  std::string bytes;
  archive::Writer out(bytes);
  out(from);
  archive::Reader in(bytes);
  in(to);
}

archive::WorldCounts counts_of(const CellSettings& settings,
                               const std::vector<robot::ArmModel>& models,
                               const physics::PhysicsWorld& physics) {
  archive::WorldCounts counts;
  counts.parts = static_cast<int>(settings.bodies.size());
  counts.tools = static_cast<int>(settings.tool_count);
  counts.fixed = static_cast<int>(physics.fixed_names().size());
  counts.belt = settings.conveyor.has_value();
  counts.light_curtain = settings.light_curtain.has_value();
  if (counts.belt) counts.photo_eyes = static_cast<int>(settings.conveyor->photo_eyes.size());
  const physics::BodyIds ids(counts.parts, counts.tools);
  counts.bodies.assign(static_cast<std::size_t>(ids.free_count()), true);
  for (std::size_t r = 0; r < models.size(); ++r) {
    const int robot = static_cast<int>(r);
    const int links = static_cast<int>(models[r].links.size());
    counts.robots.push_back({.joints = models[r].dof(), .links = links});
    counts.bodies.resize(static_cast<std::size_t>(ids.link(robot, links)), false);
    for (int id = ids.palm(robot); id < ids.link(robot, links); ++id) {
      counts.bodies[static_cast<std::size_t>(id)] = true;
    }
  }
  return counts;
}

ConveyorDriveLimits limits_of(const scene::Conveyor& belt) {
  return {belt.max_speed_m_s, belt.max_accel_m_s2, belt.max_decel_m_s2, belt.emergency_decel_m_s2};
}

}  // namespace

ArmModels load_models(const scene::Scene& scene) {
  std::vector<robot::ArmModel> models;
  for (const auto& robot : scene.robots) {
    auto model = robot::load_arm_model(robot.model_file);
    if (!model) throw std::runtime_error("robot " + robot.name + ": " + model.error().message);
    models.push_back(std::move(*model));
  }
  return std::make_shared<const std::vector<robot::ArmModel>>(std::move(models));
}

ArmModels models_for(const scene::Scene& scene, const scene::Scene& known,
                     const ArmModels& models) {
  const bool same = std::ranges::equal(scene.robots, known.robots, {}, &scene::Robot::model_file,
                                       &scene::Robot::model_file);
  return same ? models : load_models(scene);
}

World::World(std::shared_ptr<const scene::Scene> scene, std::uint64_t seed,
             std::span<robot::PlanPrefetcher* const> prefetchers)
    : World(scene, load_models(*scene), seed, prefetchers) {}

World::World(std::shared_ptr<const scene::Scene> scene, ArmModels models, std::uint64_t seed,
             std::span<robot::PlanPrefetcher* const> prefetchers)
    : scene_(std::move(scene)),
      prefetchers_(prefetchers.begin(), prefetchers.end()),
      models_(std::move(models)),
      settings_(settings_of(*scene_, *models_)),
      seed_(seed),
      surroundings_(std::make_unique<CellSurroundings>(*scene_, *models_)) {
  robots_.reserve(models_->size());
  std::vector<std::vector<Eigen::Isometry3d>> X_WL;
  for (std::size_t i = 0; i < models_->size(); ++i) {
    robots_.emplace_back(*scene_, i, (*models_)[i],
                         i < prefetchers.size() ? prefetchers[i] : nullptr, surroundings_.get());
    const auto links = robots_.back().X_WL();
    X_WL.emplace_back(links.begin(), links.end());
  }
  physics_.emplace(*scene_, *models_, X_WL);
  counts_ = std::make_shared<const archive::WorldCounts>(counts_of(settings_, *models_, *physics_));
  devices_ =
      std::make_unique<devices::DeviceGroup>(*scene_, devices::names_of(*scene_), scene_->file);
  describe();
  loose_.reserve(settings_.tool_count);
  if (settings_.conveyor) {
    conveyor_.emplace(limits_of(*settings_.conveyor));
    photo_eyes_.emplace(*settings_.conveyor);
  }
  occluders_.emplace(*scene_, *models_);
  vision_.emplace(*scene_, settings_.step_size, seed, settings_.bodies.size());
  if (settings_.light_curtain) light_curtain_.emplace(*settings_.light_curtain);
  sense();
}

// ---- commands

Result<void> World::apply_any(api::Ticket ticket, const api::Command& command) {
  return std::visit(
      [&](const auto& body) -> Result<void> {
        using Body = std::decay_t<decltype(body)>;
        if constexpr (std::is_same_v<Body, api::FaultCommand> ||
                      std::is_same_v<Body, api::TrajectoryCommand> ||
                      std::is_same_v<Body, api::SetSignals>) {
          return apply(ticket, body);
        } else if constexpr (std::is_same_v<Body, api::SceneCommand>) {
          return fail(ErrorCode::kUnimplemented, "scene", "it takes another world: SceneEditor");
        } else if constexpr (!std::is_same_v<Body, api::SimulationCommand>) {
          apply(ticket, body);
        }
        return {};
      },
      command.body);
}

void World::apply(api::Ticket ticket, const api::RobotCommand& command) {
  standstill_.end();
  SimulatedRobot& robot = robots_.at(static_cast<std::size_t>(command.robot));
  set_surroundings();
  robot.apply(ticket, command);
  if (detector_) detector_->detect_robot_events(command.robot, robot, now());
  stop_robots_if_broken();
  if (detector_) detector_->detect_robot_events(command.robot, robot, now());
}

Result<void> World::apply(api::Ticket ticket, const api::TrajectoryCommand& command) {
  standstill_.end();
  set_surroundings();
  auto done = robots_.at(static_cast<std::size_t>(command.robot)).apply(ticket, command);
  // A robot that is reset while the curtain is broken stops again at once.
  stop_robots_if_broken();
  return done;
}

void World::apply(api::Ticket, const api::ConveyorCommand& command) {
  standstill_.end();
  if (!conveyor_) return;
  conveyor_->apply(command);
  if (detector_) detector_->detect_drive_trip(*conveyor_, now());
}

void World::apply(api::Ticket, const api::SetIntruder& command) {
  standstill_.end();
  intruder_ = command.intruder;
  gather_intruders(lasting_effects().intruders);
  occluders_->gather(robots_, *physics_, intruders_);
  read_light_curtain();
}

Result<void> World::apply(api::Ticket, const api::SetSignals& command) {
  if (auto ok = devices::check_settings(command, description_->devices); !ok) return ok;
  standstill_.end();
  for (const api::SignalSetting& setting : command.settings) devices_->set_input(setting);
  return {};
}

Result<void> World::apply(api::Ticket ticket, const api::FaultCommand& command) {
  standstill_.end();
  if (const auto* inject = std::get_if<api::InjectFault>(&command)) {
    auto spec = spec_of(*inject, description_);
    if (!spec) return tl::unexpected(spec.error());
    const auto id = faults_.inject(ticket, *inject, *std::move(spec));
    return id ? Result<void>{} : tl::unexpected(id.error());
  }
  if (const auto* end = std::get_if<api::EndFault>(&command)) return faults_.end(end->id);
  const std::string& event = std::get<api::ReportEvent>(command).event;
  faults_.report(event);
  if (detector_) detector_->add(now(), {.kind = api::CellEventKind::kReported, .text = event});
  return {};
}

Result<std::shared_ptr<robot::MovePreview>> World::preview(
    const api::RobotCommand& command, std::optional<api::PlanningMode> mode) const {
  set_surroundings();
  return robots_.at(static_cast<std::size_t>(command.robot)).preview(command.action, mode);
}

// ---- one step

void World::step() {
  if (standstill_.holds()) return step_still(1);
  const std::uint64_t next = steps_ + 1;
  const bool sensors = reads_sensors_at(next);
  const bool proves = !awaits_time() && !vision_->due(next) &&
                      standstill_.wants_proof(sensors, [this] { return state_hash(); });
  if (!proves) return advance();
  WorldState expected = save();
  expected.advance_clocks(settings_.step_s, step_size());
  advance();
  standstill_.prove(sensors, to_bytes(expected), to_bytes(save()));
}

/// Whether a time is bound to come at which something happens in a cell that is at rest.
bool World::awaits_time() const {
  return !faults_.idle() || !devices_->empty() || (conveyor_ && conveyor_->awaits_time()) ||
         std::ranges::any_of(robots_, &SimulatedRobot::awaits_time) ||
         (detector_ && !detector_->save().empty());
}

void World::step_still(std::uint64_t steps) {
  const std::uint64_t first = steps_ + 1;
  steps_ += steps;
  for (auto& robot : robots_) robot.advance_clock(steps);
  if (conveyor_) conveyor_->advance_clock(settings_.step_s, steps);
  physics_->advance_clock(steps);
  if (vision_->due(first, steps_)) occluders_->gather(robots_, *physics_, intruders_);
  vision_->advance_still(first, steps_, settings_.bodies, occluders_->X_WP(), occluders_->all());
}

void World::advance() {
  // Injected faults begin and end between two steps.
  run_faults();
  run_devices();
  set_surroundings();
  for (std::size_t i = 0; i < robots_.size(); ++i) step_robot(i);
  // The belt's drive advances its ramp; the physics carries the bodies on the belt.
  if (conveyor_) physics_->set_belt_speed(conveyor_->step(settings_.step_s));
  // Contacts are found and solved, bodies and fingers moved.
  physics_->step();
  ++steps_;
  record_unintended_contacts();
  // Sensors read the state at the step's end.
  sense();
  if (detector_) detector_->detect(*physics_, robots_, conveyor(), now());
}

/// A world that was moved has its parts elsewhere.
void World::set_surroundings() const { surroundings_->set_present(robots_, *physics_, intruders_); }

void World::run_faults() {
  if (faults_.idle()) return;
  const FaultSchedule::Changes changes = faults_.advance(time(), steps_, readings());
  if (!changes.any()) return;
  FaultExecutor executor({settings_, robots_, *physics_, conveyor_ ? &*conveyor_ : nullptr,
                          photo_eyes_ ? &*photo_eyes_ : nullptr, *vision_});
  for (const std::uint64_t id : changes.begun) {
    const FaultSpec* fault = faults_.spec(id);
    const std::string note = fault ? executor.carry_out(*fault) : std::string();
    if (!note.empty()) faults_.set_note(id, note);
  }
  if (detector_) report_faults(changes);
  const FaultEffects effects = lasting_effects();
  executor.apply(effects);
  const std::size_t before = intruders_.size();
  gather_intruders(effects.intruders);
  if (before == intruders_.size()) return;
  occluders_->gather(robots_, *physics_, intruders_);
  read_light_curtain();
}

void World::run_devices() {
  if (devices_->empty()) return;
  const auto actions =
      devices_->step(device_view_.of({.settings = settings_,
                                      .robot_names = devices_->names().robots,
                                      .robots = robots_,
                                      .physics = *physics_,
                                      .conveyor = conveyor(),
                                      .photo_eyes = photo_eyes_ ? &*photo_eyes_ : nullptr,
                                      .step = steps_,
                                      .time = time()}));
  DeviceExecutor executor(
      {robots_, *physics_, conveyor_ ? &*conveyor_ : nullptr, settings_.step_s});
  for (const devices::Action& action : actions) executor.carry_out(action);
}

void World::step_robot(std::size_t i) {
  const int index = static_cast<int>(i);
  SimulatedRobot& robot = robots_[i];
  gather_loose_tools(robot);
  // The last step's contacts load the joints; the controller gives the next reference.
  robot.see_light_curtain(curtain_.broken);
  robot.step(physics_->gripper(index), physics_->arm_forces(index), *description_, loose_);
  if (!robot.q().allFinite()) {
    throw physics::PhysicsFailure("robot " + description_->robots[i].name +
                                  ": a joint's position is not a number");
  }
  if (robot.tool() != physics_->tool_of(index)) {
    physics_->detach_tool(index);
    if (robot.tool() >= 0) physics_->attach_tool(index, robot.tool(), robot.X_WM());
  }
  // The physics takes arm and gripper poses from the robot.
  physics_->set_arm(index, robot.X_WL());
  physics_->set_gripper_mount(index, robot.X_WM());
  physics_->set_gripper(index, robot.gripper_setting());
  physics_->set_gripper_force(index, robot.gripper_force_n());
}

/// For a robot without a tool: the tools that no robot has, also none before it in this step.
void World::gather_loose_tools(const SimulatedRobot& robot) {
  loose_.clear();
  for (int t = 0; robot.tool() < 0 && t < physics_->tool_count(); ++t) {
    const physics::BodyState tool = physics_->tool(t);
    if (robot_with(t) >= 0 || tool.lost_step) continue;
    loose_.push_back({t, Pose{tool.p_WB, tool.q_WB}.isometry()});
  }
}

int World::robot_with(int tool) const {
  for (int r = 0; r < static_cast<int>(robots_.size()); ++r) {
    if (physics_->tool_of(r) == tool) return r;
  }
  return -1;
}

void World::record_unintended_contacts() {
  for (int r = 0; r < static_cast<int>(robots_.size()); ++r) {
    unintended_contacts_.add(steps_, r, physics_->arm_forces(r), physics_->tool_of(r) >= 0,
                             settings_.bodies);
  }
}

/// Belt sensors and light curtain are read in the step that reaches the next cycle.
bool World::reads_sensors_at(std::uint64_t step) const {
  return step_size() * static_cast<SimTime::rep>(step) % kSensorPeriod < step_size();
}

void World::sense() {
  const bool cycle = reads_sensors_at(steps_);
  // Cameras and light curtain share one list of occluders.
  if (vision_->due(steps_) || (light_curtain_ && cycle)) {
    occluders_->gather(robots_, *physics_, intruders_);
  }
  vision_->advance(steps_, settings_.bodies, occluders_->X_WP(), occluders_->all());
  if (!cycle) return;
  read_photo_eyes();
  read_light_curtain();
}

void World::read_photo_eyes() {
  if (!photo_eyes_) return;
  photo_eyes_->begin();
  for (int i = 0; i < physics_->body_count(); ++i) {
    const physics::BodyState state = physics_->body(i);
    if (state.lost_step) continue;
    photo_eyes_->see(settings_.bodies[static_cast<std::size_t>(i)], {state.p_WB, state.q_WB});
  }
  photo_eyes_->finish();
  conveyor_->set_load(photo_eyes_->load_kg());
}

void World::read_light_curtain() {
  if (!light_curtain_) return;
  curtain_ = light_curtain_->measure(occluders_->all());
  if (conveyor_ && settings_.curtain_stops_belt()) conveyor_->set_light_curtain(curtain_.broken);
  stop_robots_if_broken();
}

// A robot that is initialised while the curtain is broken stops again at once.
void World::stop_robots_if_broken() {
  if (!curtain_.broken || !settings_.curtain_stops_robots()) return;
  for (auto& robot : robots_) robot.stop_for_light_curtain();
}

// ---- changes of the scene

std::unique_ptr<World> World::in_scene(scene::Scene scene) const {
  auto world = std::make_unique<World>(std::make_shared<const scene::Scene>(std::move(scene)),
                                       models_, seed_, prefetchers_);
  world->base_ = base_ ? base_ : scene_;
  world->set_revision(revision_ + 1);
  return world;
}

void World::adopt(const World& old, std::span<const int> old_of) {
  standstill_.end();
  std::vector<int> new_of(old.settings_.bodies.size(), -1);
  for (std::size_t i = 0; i < old_of.size(); ++i) {
    if (old_of[i] >= 0) new_of[static_cast<std::size_t>(old_of[i])] = static_cast<int>(i);
  }
  steps_ = old.steps_;
  for (std::size_t i = 0; i < robots_.size(); ++i) robots_[i].restore(old.robots_[i].save());
  physics_->adopt(*old.physics_, old_of);
  if (conveyor_) copy_state(*old.conveyor_, *conveyor_);
  if (photo_eyes_) copy_state(*old.photo_eyes_, *photo_eyes_);
  copy_state(*old.vision_, *vision_);
  vision_->renumber(new_of);
  curtain_ = old.curtain_;
  intruder_ = old.intruder_;
  faults_ = old.faults_;
  faults_.renumber(new_of);
  unintended_contacts_ = old.unintended_contacts_;
  unintended_contacts_.renumber(new_of);
  devices_->adopt(*old.devices_);
  gather_intruders(lasting_effects().intruders);
}

void World::put_body(int body, const Pose& X_WB) {
  standstill_.end();
  const std::array<physics::PhysicsWorld::Placement, 1> place{{{body, X_WB.isometry()}}};
  physics_->place(place);
}

void World::remove_body(int body) {
  standstill_.end();
  physics_->remove(body);
}

// ---- events

void World::watch_events() {
  detector_.emplace();
  begin_detection({});
}

void World::begin_detection(EventDetector::State apart) {
  detector_->begin(description_, *physics_, robots_, conveyor(), now(), std::move(apart));
}

std::vector<api::CellEvent>* World::events() { return detector_ ? &detector_->found() : nullptr; }

void World::report_faults(const FaultSchedule::Changes& changes) {
  const auto report = [&](api::CellEventKind kind, std::uint64_t id) {
    const auto& all = faults_.list()->all;
    const auto fault = std::ranges::find(all, id, &api::InjectedFault::id);
    if (fault != all.end()) detector_->report_fault(now(), kind, *fault);
  };
  for (const std::uint64_t id : changes.begun) report(api::CellEventKind::kFaultBegun, id);
  for (const std::uint64_t id : changes.ended) report(api::CellEventKind::kFaultEnded, id);
}

// ---- faults and intruders

CellReadings World::readings() const {
  return {settings_, robots_, *physics_, conveyor(), photo_eyes_ ? &*photo_eyes_ : nullptr};
}

bool World::beyond(const api::WhenCrossing& crossing, int robot) const {
  const double value = readings().quantity(crossing.quantity, robot, crossing.joint - 1);
  return crossing.above ? value > crossing.limit : value < crossing.limit;
}

FaultEffects World::lasting_effects() const {
  return effects_of(faults_.active(), time(), settings_.joint_names, settings_.light_curtain);
}

void World::gather_intruders(std::span<const api::Intruder> of_faults) {
  intruders_.clear();
  if (intruder_) intruders_.push_back(*intruder_);
  intruders_.insert(intruders_.end(), of_faults.begin(), of_faults.end());
}

// ---- state

WorldState World::save() const {
  WorldState state{.scene = scene_,
                   .base = base_,
                   .models = models_,
                   .counts = counts_,
                   .seed = seed_,
                   .steps = steps_,
                   .conveyor = conveyor_,
                   .photo_eyes = photo_eyes_,
                   .physics = physics_->save(),
                   .vision = vision_,
                   .curtain = curtain_,
                   .intruder = intruder_,
                   .faults = faults_,
                   .unintended_contacts = unintended_contacts_,
                   .devices = devices_->state(),
                   .apart = detector_ ? detector_->save() : EventDetector::State{}};
  for (const auto& robot : robots_) state.robots.push_back(robot.save());
  return state;
}

void World::restore(const WorldState& state) {
  if (state.robots.size() != robots_.size()) {
    throw std::invalid_argument("the saved state has " + std::to_string(state.robots.size()) +
                                " robots, this cell " + std::to_string(robots_.size()));
  }
  standstill_.end();
  base_ = state.base;
  physics_->restore(state.physics);
  for (std::size_t i = 0; i < robots_.size(); ++i) robots_[i].restore(state.robots[i]);
  if (std::exchange(seed_, state.seed) != state.seed) describe();
  steps_ = state.steps;
  conveyor_ = state.conveyor;
  photo_eyes_ = state.photo_eyes;
  vision_ = state.vision;
  curtain_ = state.curtain;
  intruder_ = state.intruder;
  faults_ = state.faults;
  unintended_contacts_ = state.unintended_contacts;
  devices_->set_state(state.devices);
  gather_intruders(lasting_effects().intruders);
  if (detector_) begin_detection(state.apart);
}

SimTime World::time() const { return step_size() * static_cast<SimTime::rep>(steps_); }

std::uint64_t World::plan_waits() const {
  std::uint64_t waits = 0;
  for (const auto& robot : robots_) waits += robot.plan_waits();
  return waits;
}

std::uint64_t World::state_hash() const {
  std::uint64_t hash = physics_->state_hash();
  for (const auto& robot : robots_) {
    for (const double position_rad : robot.q()) mix(hash, position_rad);
  }
  if (conveyor_) mix(hash, conveyor_->state().travel_m);
  for (const devices::DeviceState& device : devices_->state()) {
    for (const double number : device.numbers) mix(hash, number);
    mix(hash, device.fault.empty() ? 0 : 1);
  }
  return hash;
}

// ---- publication

void World::set_revision(std::uint64_t revision) {
  if (std::exchange(revision_, revision) != revision) describe();
}

void World::describe() {
  auto cell = std::make_shared<api::CellDescription>(describe_cell(*scene_));
  cell->seed = seed_;
  cell->revision = revision_;
  cell->step_size = step_size();
  for (std::size_t i = 0; i < models_->size(); ++i) {
    cell->robots.push_back(describe_robot(scene_->robots[i], (*models_)[i]));
  }
  cell->fixed = physics_->fixed_names();
  devices_->describe(cell->devices);
  for (const scene::ModbusServer& server : scene_->modbus_servers) {
    api::RegisterMap& map = cell->modbus_servers.emplace_back();
    map.name = server.name;
    for (const auto& mapped : server.registers) map.registers.push_back(mapped.data);
  }
  description_ = std::move(cell);
}

void World::write(api::Snapshot& out) const {
  out.cell = description_;
  out.step = steps_;
  out.time = time();
  out.robots.resize(robots_.size());
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const int index = static_cast<int>(i);
    robots_[i].write(physics_->gripper(index), physics_->arm_forces(index), out.robots[i]);
    out.robots[i].vision = vision_->latest(i);
  }
  out.conveyor = conveyor_ ? conveyor_->readings() : api::ConveyorSnapshot{};
  if (photo_eyes_) out.conveyor.photo_eyes = photo_eyes_->eyes();
  out.light_curtain = curtain_;
  out.intruder = intruders_.empty() ? std::nullopt : std::optional(intruders_.front());
  out.faults = faults_.list();
  write_bodies(out.bodies);
  write_tools(out.tools);
  devices_->write(out.devices);
  out.contact_count = physics_->contact_count();
  physics_->write_contacts(out.contacts);
  out.unintended_contacts = unintended_contacts_.list();
  out.virtual_joint_count = physics_->virtual_joint_count();
  out.max_penetration_m = physics_->max_penetration_m();
  out.physics_faults = physics_->penetration_faults();
  out.solver_failures = physics_->solver_failures();
  out.solver_step = physics_->solver_step();
}

void World::write_bodies(std::vector<api::BodySnapshot>& out) const {
  out.resize(settings_.bodies.size());
  for (int i = 0; i < physics_->body_count(); ++i) {
    const physics::BodyState state = physics_->body(i);
    out[static_cast<std::size_t>(i)] = {.X_WB = {state.p_WB, state.q_WB},
                                        .v_W = state.v_W,
                                        .omega_W = state.omega_W,
                                        .resting = state.resting,
                                        .group_kind = state.group_kind,
                                        .group = state.group,
                                        .lost_step = state.lost_step};
  }
}

void World::write_tools(std::vector<api::ToolSnapshot>& out) const {
  out.resize(settings_.tool_count);
  for (int i = 0; i < physics_->tool_count(); ++i) {
    const physics::BodyState state = physics_->tool(i);
    const int robot = robot_with(i);
    out[static_cast<std::size_t>(i)] = {.X_WT = {state.p_WB, state.q_WB},
                                        .robot = robot,
                                        .separation_m = physics_->opening(i),
                                        .resting = robot < 0 && state.resting,
                                        .lost_step = state.lost_step};
  }
}

}  // namespace aprsim::world
