#include "world/cell/world.hpp"

#include <bit>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "world/cell/describe_cell.hpp"

namespace aprsim::world {
namespace {

// How often belt sensors and light curtain are looked at: the cycle of an ordinary PLC.
constexpr SimTime kSensorPeriod = std::chrono::milliseconds(10);

/// FNV-1a over the bits of a value.
void mix(std::uint64_t& hash, double value) {
  hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3ULL;
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

World::World(std::shared_ptr<const scene::Scene> scene, std::uint64_t seed,
             std::span<robot::PlanPrefetcher* const> prefetchers)
    : World(scene, load_models(*scene), seed, prefetchers) {}

World::World(std::shared_ptr<const scene::Scene> scene, ArmModels models, std::uint64_t seed,
             std::span<robot::PlanPrefetcher* const> prefetchers)
    : scene_(std::move(scene)),
      prefetchers_(prefetchers.begin(), prefetchers.end()),
      step_size_(std::llround(scene_->physics.step_s * 1e9)),
      models_(std::move(models)) {
  robots_.reserve(models_->size());
  std::vector<std::vector<Eigen::Isometry3d>> X_WL;
  for (std::size_t i = 0; i < models_->size(); ++i) {
    robots_.emplace_back(*scene_, i, (*models_)[i],
                         i < prefetchers.size() ? prefetchers[i] : nullptr);
    const auto links = robots_.back().X_WL();
    X_WL.emplace_back(links.begin(), links.end());
  }
  physics_.emplace(*scene_, *models_, X_WL);
  describe(seed);
  loose_.reserve(description_->tools.size());
  if (const auto& belt = scene_->conveyor) {
    conveyor_.emplace(ConveyorDriveLimits{belt->max_speed_m_s, belt->max_accel_m_s2,
                                          belt->max_decel_m_s2, belt->emergency_decel_m_s2});
    photo_eyes_.emplace(description_->conveyor);
  }
  occluders_.emplace(*scene_, *models_);
  vision_.emplace(*scene_, step_size_, seed, description_->bodies.size());
  if (description_->light_curtain) light_curtain_.emplace(*description_->light_curtain);
  sense();
}

void World::describe(std::uint64_t seed) {
  auto cell = std::make_shared<api::CellDescription>(describe_cell(*scene_));
  cell->seed = seed;
  cell->revision = revision_;
  cell->step_size = step_size_;
  for (const auto& robot : robots_) cell->robots.push_back(robot.description());
  cell->fixed = physics_->fixed_names();
  description_ = std::move(cell);
}

Result<void> World::apply_any(api::Ticket ticket, const api::Command& command) {
  return std::visit(
      [&](const auto& body) -> Result<void> {
        using Body = std::decay_t<decltype(body)>;
        if constexpr (std::is_same_v<Body, api::FaultCommand>) {
          return apply(ticket, body);
        } else if constexpr (std::is_same_v<Body, api::SceneCommand>) {
          return fail(ErrorCode::kUnimplemented, "scene", "it takes another world: carry_out()");
        } else if constexpr (!std::is_same_v<Body, api::SimulationCommand>) {
          apply(ticket, body);
        }
        return {};
      },
      command.body);
}

void World::apply(api::Ticket ticket, const api::RobotCommand& command) {
  SimulatedRobot& robot = robots_.at(static_cast<std::size_t>(command.robot));
  robot.apply(ticket, command);
  if (watch_) watch_->look_at_robot(command.robot, robot, now());
  stop_robots_if_broken();
  if (watch_) watch_->look_at_robot(command.robot, robot, now());
}

void World::apply(api::Ticket, const api::ConveyorCommand& command) {
  if (!conveyor_) return;
  conveyor_->apply(command);
  if (watch_) watch_->look_at_belt(*conveyor_, now());
}

void World::apply(api::Ticket, const api::SetIntruder& command) {
  intruder_ = command.intruder;
  gather_intruders(effects_of(faults_.active(), time(), *description_).intruders);
  occluders_->gather(robots_, *physics_, intruders_);
  look_through_curtain();
}

void World::step() {
  // Injected faults begin and end between two steps.
  run_faults();
  for (std::size_t i = 0; i < robots_.size(); ++i) step_robot(i);
  // The belt's drive advances its ramp; the physics carries what lies on the belt.
  if (conveyor_) physics_->set_belt_speed(conveyor_->step(scene_->physics.step_s));
  // Contacts are found and solved, bodies and fingers moved.
  physics_->step();
  ++steps_;
  note_touches();
  // The sensors look at the step's end.
  sense();
  if (watch_) watch_->look(*physics_, robots_, conveyor_ ? &*conveyor_ : nullptr, now());
}

void World::watch_events() {
  watch_.emplace();
  begin_watch({});
}

void World::begin_watch(CellWatch::State apart) {
  watch_->begin(description_, *physics_, robots_, conveyor_ ? &*conveyor_ : nullptr, now(),
                std::move(apart));
}

std::vector<api::CellEvent>* World::events() { return watch_ ? &watch_->found() : nullptr; }

void World::step_robot(std::size_t i) {
  const int index = static_cast<int>(i);
  SimulatedRobot& robot = robots_[i];
  // What the robots before this one have taken is gone.
  loose_.clear();
  for (int t = 0; robot.tool() < 0 && t < physics_->tool_count(); ++t) {
    const physics::BodyState tool = physics_->tool(t);
    if (robot_with(t) >= 0 || tool.lost_step) continue;
    loose_.push_back({t, Pose{tool.p_WB, tool.q_WB}.isometry()});
  }
  // The last step's contacts load the joints; the controller gives the next reference.
  robot.see_light_curtain(curtain_.broken);
  robot.step(physics_->gripper(index), physics_->arm_forces(index), *description_, loose_);
  if (robot.tool() != physics_->tool_of(index)) {
    physics_->leave_tool(index);
    if (robot.tool() >= 0) physics_->take_tool(index, robot.tool(), robot.X_WM());
  }
  // Towards the physics, arms and grippers are where the robots say.
  physics_->set_arm(index, robot.X_WL());
  physics_->set_gripper_mount(index, robot.X_WM());
  physics_->set_gripper(index, robot.gripper_setting());
  physics_->set_gripper_force(index, robot.gripper_force_n());
}

void World::note_touches() {
  for (int r = 0; r < static_cast<int>(robots_.size()); ++r) {
    touches_.add(steps_, r, physics_->arm_forces(r), physics_->tool_of(r) >= 0, *description_);
  }
}

int World::robot_with(int tool) const {
  for (int r = 0; r < static_cast<int>(robots_.size()); ++r) {
    if (physics_->tool_of(r) == tool) return r;
  }
  return -1;
}

WorldState World::save() const {
  WorldState state{.scene = scene_,
                   .base = base_,
                   .seed = description_->seed,
                   .steps = steps_,
                   .conveyor = conveyor_,
                   .photo_eyes = photo_eyes_,
                   .physics = physics_->save(),
                   .vision = vision_,
                   .curtain = curtain_,
                   .intruder = intruder_,
                   .faults = faults_,
                   .touches = touches_,
                   .apart = watch_ ? watch_->save() : CellWatch::State{}};
  for (const auto& robot : robots_) state.robots.push_back(robot.save());
  return state;
}

void World::restore(const WorldState& state) {
  if (state.robots.size() != robots_.size()) {
    throw std::invalid_argument("the saved state has " + std::to_string(state.robots.size()) +
                                " robots, this cell " + std::to_string(robots_.size()));
  }
  base_ = state.base;
  physics_->restore(state.physics);
  for (std::size_t i = 0; i < robots_.size(); ++i) robots_[i].restore(state.robots[i]);
  if (state.seed != description_->seed) describe(state.seed);
  steps_ = state.steps;
  conveyor_ = state.conveyor;
  photo_eyes_ = state.photo_eyes;
  vision_ = state.vision;
  curtain_ = state.curtain;
  intruder_ = state.intruder;
  faults_ = state.faults;
  touches_ = state.touches;
  gather_intruders(effects_of(faults_.active(), time(), *description_).intruders);
  if (watch_) begin_watch(state.apart);
}

void World::sense() {
  const bool cycle = time() % kSensorPeriod < step_size_;
  // Cameras and light curtain look at one picture of what is in the way.
  if (vision_->due(steps_) || (light_curtain_ && cycle)) {
    occluders_->gather(robots_, *physics_, intruders_);
  }
  vision_->look(steps_, *description_, *occluders_);
  if (!cycle) return;
  look_at_belt();
  look_through_curtain();
}

void World::look_through_curtain() {
  if (!light_curtain_) return;
  curtain_ = light_curtain_->look(occluders_->all());
  const api::CurtainReaction reaction = description_->light_curtain->reaction;
  const bool stops_belt =
      reaction == api::CurtainReaction::kBeltStop || reaction == api::CurtainReaction::kAll;
  if (conveyor_ && stops_belt) conveyor_->set_light_curtain(curtain_.broken);
  stop_robots_if_broken();
}

// A robot that is initialised while the curtain is broken stops again at once.
void World::stop_robots_if_broken() {
  if (!curtain_.broken) return;
  const api::CurtainReaction reaction = description_->light_curtain->reaction;
  if (reaction != api::CurtainReaction::kProtectiveStop && reaction != api::CurtainReaction::kAll) {
    return;
  }
  for (auto& robot : robots_) robot.stop_for_light_curtain();
}

void World::look_at_belt() {
  if (!photo_eyes_) return;
  photo_eyes_->begin();
  for (int i = 0; i < physics_->body_count(); ++i) {
    const physics::BodyState state = physics_->body(i);
    if (state.lost_step) continue;
    photo_eyes_->see(description_->bodies[static_cast<std::size_t>(i)], {state.p_WB, state.q_WB});
  }
  photo_eyes_->finish();
  conveyor_->set_load(photo_eyes_->load_kg());
}

SimTime World::time() const { return step_size_ * static_cast<SimTime::rep>(steps_); }

std::uint64_t World::plan_waits() const {
  std::uint64_t waits = 0;
  for (const auto& robot : robots_) waits += robot.plan_waits();
  return waits;
}

std::uint64_t World::state_hash() const {
  std::uint64_t hash = physics_->state_hash();
  api::RobotSnapshot robot;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    robots_[i].write({}, {}, robot);
    for (int j = 0; j < (*models_)[i].dof(); ++j) {
      mix(hash, robot.joints[static_cast<std::size_t>(j)].position_rad);
    }
  }
  if (conveyor_) mix(hash, conveyor_->state().travel_m);
  return hash;
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
  const int count = physics_->body_count();
  out.bodies.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const physics::BodyState state = physics_->body(i);
    out.bodies[static_cast<std::size_t>(i)] = {.X_WB = {state.p_WB, state.q_WB},
                                               .v_W = state.v_W,
                                               .omega_W = state.omega_W,
                                               .resting = state.resting,
                                               .group_kind = state.group_kind,
                                               .group = state.group,
                                               .lost_step = state.lost_step};
  }
  out.tools.resize(description_->tools.size());
  for (int i = 0; i < physics_->tool_count(); ++i) {
    const physics::BodyState state = physics_->tool(i);
    const int robot = robot_with(i);
    out.tools[static_cast<std::size_t>(i)] = {.X_WT = {state.p_WB, state.q_WB},
                                              .robot = robot,
                                              .separation_m = physics_->opening(i),
                                              .resting = robot < 0 && state.resting,
                                              .lost_step = state.lost_step};
  }
  out.contact_count = physics_->contact_count();
  physics_->write_contacts(out.contacts);
  out.robot_touches = touches_.list();
  out.virtual_joint_count = physics_->virtual_joint_count();
  out.max_penetration_m = physics_->max_penetration_m();
  out.physics_faults = physics_->penetration_faults();
  out.solver_failures = physics_->solver_failures();
  out.solver_step = physics_->solver_step();
}

}  // namespace aprsim::world
