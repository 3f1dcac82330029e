#include "world/world.hpp"

#include <bit>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace aprsim::world {
namespace {

// How often belt sensors and light curtain are looked at: the cycle of an ordinary PLC.
constexpr SimTime kSensorPeriod = std::chrono::milliseconds(10);

std::vector<robot::ArmModel> load_models(const scene::Scene& scene) {
  std::vector<robot::ArmModel> models;
  for (const auto& robot : scene.robots) {
    auto model = robot::load_arm_model(robot.model_file);
    if (!model) throw std::runtime_error("robot " + robot.name + ": " + model.error().message);
    models.push_back(std::move(*model));
  }
  return models;
}

api::BodyDescription describe_tray(const scene::TrayInstance& tray, const scene::TrayType& type) {
  api::BodyDescription out;
  out.name = tray.name;
  out.type = tray.type;
  out.kind = type.kind;
  out.mass_kg = type.mass_kg;
  out.box_min = {type.min_xy.x(), type.min_xy.y(), -type.thickness_m};
  out.box_max = {type.max_xy.x(), type.max_xy.y(), 0};
  for (const auto& slot : type.slots) {
    Pose X_PS;
    X_PS.p = {slot.xy.x(), slot.xy.y(), 0};
    out.slots.push_back({.name = slot.name, .gear_type = slot.gear_type, .X_PS = X_PS});
  }
  return out;
}

api::BodyDescription describe_gear(const scene::GearInstance& gear, const scene::GearType& type) {
  api::BodyDescription out;
  out.name = gear.name;
  out.type = gear.type;
  out.kind = api::BodyKind::kGear;
  out.mass_kg = type.mass_kg;
  out.disc_radius_m = type.disc_radius_m;
  out.disc_height_m = type.disc_height_m;
  out.peg_radius_m = type.peg_radius_m;
  out.peg_top_m = type.peg_top_m;
  return out;
}

/// FNV-1a over the bits of a value.
void mix(std::uint64_t& hash, double value) {
  hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3ULL;
}

}  // namespace

World::World(std::shared_ptr<const scene::Scene> scene, std::uint64_t seed)
    : scene_(std::move(scene)),
      step_size_(std::llround(scene_->physics.step_s * 1e9)),
      models_(load_models(*scene_)) {
  robots_.reserve(models_.size());
  std::vector<std::vector<Eigen::Isometry3d>> X_WL;
  for (std::size_t i = 0; i < models_.size(); ++i) {
    robots_.emplace_back(scene_->robots[i], models_[i], scene_->physics);
    const auto links = robots_.back().X_WL();
    X_WL.emplace_back(links.begin(), links.end());
  }
  if (const auto& belt = scene_->conveyor) {
    conveyor_.emplace(ConveyorDriveLimits{belt->max_speed_m_s, belt->max_accel_m_s2,
                                          belt->max_decel_m_s2, belt->emergency_decel_m_s2});
  }
  physics_.emplace(*scene_, models_, X_WL);
  describe(seed);
  solids_.emplace(*scene_, models_);
  vision_.emplace(*scene_, step_size_, seed, description_->bodies.size());
  if (conveyor_) photo_eyes_.emplace(description_->conveyor);
  if (description_->light_curtain) light_curtain_.emplace(*description_->light_curtain);
  sense();
}

void World::describe(std::uint64_t seed) {
  auto cell = std::make_shared<api::CellDescription>();
  cell->scene = scene_->name;
  cell->seed = seed;
  cell->step_size = step_size_;
  for (const auto& robot : robots_) cell->robots.push_back(robot.description());
  if (const auto& belt = scene_->conveyor) {
    cell->has_conveyor = true;
    cell->conveyor = {.X_WC = belt->X_WC,
                      .length_m = belt->length_m,
                      .width_m = belt->width_m,
                      .max_speed_m_s = belt->max_speed_m_s,
                      .max_accel_m_s2 = belt->max_accel_m_s2,
                      .max_decel_m_s2 = belt->max_decel_m_s2,
                      .emergency_decel_m_s2 = belt->emergency_decel_m_s2};
    for (const auto& eye : belt->photo_eyes) {
      cell->conveyor.photo_eyes.push_back(
          {.name = eye.name, .x_m = eye.x_m, .height_m = eye.height_m});
    }
  }
  cell->light_curtain = scene_->light_curtain;
  for (const auto& tray : scene_->trays) {
    cell->bodies.push_back(describe_tray(tray, scene_->tray_types.at(tray.type)));
  }
  for (const auto& gear : scene_->gears) {
    cell->bodies.push_back(describe_gear(gear, scene_->gear_types.at(gear.type)));
  }
  cell->fixed = physics_->fixed_names();
  description_ = std::move(cell);
}

void World::apply(api::Ticket ticket, const api::RobotCommand& command) {
  robots_.at(static_cast<std::size_t>(command.robot)).take(ticket, command);
  stop_robots_if_broken();
}

void World::apply(api::Ticket, const api::ConveyorCommand& command) {
  if (conveyor_) conveyor_->take(command);
}

void World::apply(api::Ticket, const api::SetIntruder& command) {
  intruder_ = command.intruder;
  solids_->gather(robots_, *physics_, intruder_);
  look_through_curtain();
}

void World::step() {
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const int index = static_cast<int>(i);
    robots_[i].see_light_curtain(curtain_.broken);
    robots_[i].step(physics_->gripper(index), physics_->arm_forces(index));
    physics_->set_arm(index, robots_[i].X_WL());
    physics_->set_gripper_mount(index, robots_[i].X_WM());
    physics_->set_gripper(index, robots_[i].gripper_setting());
    physics_->set_gripper_force(index, robots_[i].gripper_force_n());
  }
  if (conveyor_) physics_->set_belt_speed(conveyor_->step(scene_->physics.step_s));
  physics_->step();
  ++steps_;
  sense();
}

WorldState World::save() const {
  WorldState state{.seed = description_->seed,
                   .steps = steps_,
                   .conveyor = conveyor_,
                   .photo_eyes = photo_eyes_,
                   .physics = physics_->save(),
                   .vision = vision_,
                   .curtain = curtain_,
                   .intruder = intruder_};
  for (const auto& robot : robots_) state.robots.push_back(robot.save());
  return state;
}

void World::restore(const WorldState& state) {
  if (state.robots.size() != robots_.size()) {
    throw std::invalid_argument("the saved state has " + std::to_string(state.robots.size()) +
                                " robots, this cell " + std::to_string(robots_.size()));
  }
  physics_->restore(state.physics);
  for (std::size_t i = 0; i < robots_.size(); ++i) robots_[i].restore(state.robots[i]);
  if (state.seed != description_->seed) describe(state.seed);
  steps_ = state.steps;
  conveyor_ = state.conveyor;
  photo_eyes_ = state.photo_eyes;
  vision_ = state.vision;
  curtain_ = state.curtain;
  intruder_ = state.intruder;
}

void World::sense() {
  const bool cycle = time() % kSensorPeriod < step_size_;
  if (vision_->due(steps_) || (light_curtain_ && cycle)) {
    solids_->gather(robots_, *physics_, intruder_);
  }
  vision_->look(steps_, *description_, *solids_);
  if (!cycle) return;
  look_at_belt();
  look_through_curtain();
}

void World::look_through_curtain() {
  if (!light_curtain_) return;
  curtain_ = light_curtain_->look(solids_->all());
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
    photo_eyes_->see(description_->bodies[static_cast<std::size_t>(i)], {state.p_WB, state.q_WB});
  }
  photo_eyes_->finish();
  conveyor_->set_load(photo_eyes_->load_kg());
}

SimTime World::time() const { return step_size_ * static_cast<SimTime::rep>(steps_); }

std::uint64_t World::state_hash() const {
  std::uint64_t hash = physics_->state_hash();
  api::RobotSnapshot robot;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    robots_[i].write({}, {}, robot);
    for (int j = 0; j < models_[i].dof(); ++j) {
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
  out.conveyor = conveyor_ ? conveyor_->state() : api::ConveyorSnapshot{};
  if (photo_eyes_) out.conveyor.photo_eyes = photo_eyes_->eyes();
  out.light_curtain = curtain_;
  out.intruder = intruder_;
  const int count = physics_->body_count();
  out.bodies.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const physics::BodyState state = physics_->body(i);
    out.bodies[static_cast<std::size_t>(i)] = {.X_WB = {state.p_WB, state.q_WB},
                                               .v_W = state.v_W,
                                               .omega_W = state.omega_W,
                                               .resting = state.resting,
                                               .group_kind = state.group_kind,
                                               .group = state.group};
  }
  out.contact_count = physics_->contact_count();
  physics_->write_contacts(out.contacts);
  out.virtual_joint_count = physics_->virtual_joint_count();
  out.max_penetration_m = physics_->max_penetration_m();
  out.physics_faults = physics_->penetration_faults();
}

}  // namespace aprsim::world
