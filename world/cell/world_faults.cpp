// What injected faults do in the cell, each at the one place where it belongs.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "world/cell/world.hpp"

namespace aprsim::world {
namespace {

using faults::Kind;

/// A gear whose underside is so near to a tray's top face stands on it [m].
constexpr double kStandsOn_m = 5e-3;
constexpr const char* kLost = "it is not in the cell any more";

Eigen::Isometry3d pose_of(const physics::BodyState& state) {
  return Pose{state.p_WB, state.q_WB}.isometry();
}

/// Turned about the vertical through its origin, and moved.
Eigen::Isometry3d shifted(const Eigen::Isometry3d& X_WB, const Eigen::Vector3d& by, double yaw) {
  Eigen::Isometry3d out = X_WB;
  out.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * X_WB.linear();
  out.translation() += by;
  return out;
}

/// Turned over where it is: its top is as high as its underside was, or lower.
Eigen::Isometry3d turned_over(const Eigen::Isometry3d& X_WB, const api::BodyDescription& gear) {
  Eigen::Isometry3d out = X_WB;
  out.linear() = X_WB.linear() * Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
  out.translation() += X_WB.linear().col(2) * std::max(gear.disc_height_m, gear.peg_top_m);
  return out;
}

bool stands_on(const Eigen::Isometry3d& X_WG, const Eigen::Isometry3d& X_WP,
               const api::BodyDescription& tray) {
  const Eigen::Vector3d p_P = X_WP.inverse() * X_WG.translation();
  return (p_P.head<2>().array() >= tray.box_min.head<2>().array()).all() &&
         (p_P.head<2>().array() <= tray.box_max.head<2>().array()).all() &&
         std::abs(p_P.z() - tray.box_max.z()) <= kStandsOn_m;
}

}  // namespace

/// The cell as its faults ask about it.
class World::Facts final : public CellFacts {
 public:
  explicit Facts(const World& world) : world_(world) {}

  [[nodiscard]] int robots() const override { return static_cast<int>(world_.robots_.size()); }

  [[nodiscard]] GripFacts grip(int robot) const override {
    return {world_.physics_->gripper(robot).held_body,
            world_.robots_[static_cast<std::size_t>(robot)].gripper_told_to_open()};
  }

  [[nodiscard]] const std::string& type_of(int body) const override {
    return world_.description_->bodies[static_cast<std::size_t>(body)].type;
  }

  [[nodiscard]] bool beam_broken(int eye) const override {
    return world_.photo_eyes_ && world_.photo_eyes_->eyes()[static_cast<std::size_t>(eye)].broken;
  }

  [[nodiscard]] double quantity(faults::Quantity quantity, int robot, int joint) const override {
    using faults::Quantity;
    if (quantity == Quantity::kBeltTravel) return world_.conveyor_->state().travel_m;
    if (quantity == Quantity::kBeltSpeed) return world_.conveyor_->state().speed_m_s;
    const physics::GripperState grip = world_.physics_->gripper(robot);
    if (quantity == Quantity::kSeparation) return grip.separation_m;
    if (quantity == Quantity::kGripForce) return std::min(grip.force_n[0], grip.force_n[1]);
    api::RobotSnapshot seen;
    world_.robots_[static_cast<std::size_t>(robot)].write(grip, world_.physics_->arm_forces(robot),
                                                          seen);
    if (quantity == Quantity::kToolHeight) return seen.X_WT.p.z();
    if (quantity == Quantity::kToolForce) return seen.force_T_R.norm();
    return seen.joints[static_cast<std::size_t>(joint)].position_rad;
  }

  [[nodiscard]] std::optional<double> distance_to_belt_end(int body) const override {
    const physics::BodyState state = world_.physics_->body(body);
    const double speed = world_.conveyor_->state().speed_m_s;
    const Pose X_WB{state.p_WB, state.q_WB};
    // A tray's origin is on its top face, no higher above the belt than a part that it carries.
    if (state.lost_step || speed == 0 || !world_.photo_eyes_->carries(X_WB)) return std::nullopt;
    const auto& belt = world_.description_->conveyor;
    const double x_C = (belt.X_WC.isometry().inverse() * X_WB.p).x();
    return 0.5 * belt.length_m - std::copysign(1.0, speed) * x_C;
  }

 private:
  const World& world_;
};

Result<void> World::apply(api::Ticket ticket, const api::FaultCommand& command) {
  if (const auto* inject = std::get_if<api::InjectFault>(&command)) {
    auto spec = resolve(*inject, *description_);
    if (!spec) return tl::unexpected(spec.error());
    const auto id = faults_.inject(ticket, *inject, *std::move(spec));
    return id ? Result<void>{} : tl::unexpected(id.error());
  }
  if (const auto* end = std::get_if<api::EndFault>(&command)) return faults_.end(end->id);
  const std::string& event = std::get<api::ReportEvent>(command).event;
  faults_.report(event);
  if (watch_) watch_->add(now(), {.kind = api::CellEventKind::kReported, .text = event});
  return {};
}

bool World::beyond(const api::WhenCrossing& crossing, int robot) const {
  const double value = Facts(*this).quantity(crossing.quantity, robot, crossing.joint - 1);
  return crossing.above ? value > crossing.limit : value < crossing.limit;
}

void World::run_faults() {
  if (faults_.idle()) return;
  const FaultSchedule::Changes changes = faults_.advance(time(), steps_, Facts(*this));
  if (!changes.any()) return;
  for (const std::uint64_t id : changes.begun) {
    const FaultSpec* fault = faults_.spec(id);
    const std::string note = fault ? carry_out(*fault) : std::string();
    if (!note.empty()) faults_.note(id, note);
  }
  if (watch_) tell_faults(changes);
  bring_into_effect(effects_of(faults_.active(), time(), *description_));
}

void World::tell_faults(const FaultSchedule::Changes& changes) {
  const auto tell = [&](api::CellEventKind kind, std::uint64_t id) {
    const auto& all = faults_.list()->all;
    const auto fault = std::ranges::find(all, id, &api::InjectedFault::id);
    if (fault == all.end()) return;
    std::string text(faults::info(fault->kind).name);
    if (!fault->note.empty()) text += ": " + fault->note;
    api::CellEvent event{
        .kind = kind, .text = std::move(text), .robot = fault->robot, .number = id};
    if (!fault->target.empty()) event.names.push_back(fault->target);
    watch_->add(now(), std::move(event));
  };
  for (const std::uint64_t id : changes.begun) tell(api::CellEventKind::kFaultBegun, id);
  for (const std::uint64_t id : changes.ended) tell(api::CellEventKind::kFaultEnded, id);
}

std::string World::carry_out(const FaultSpec& fault) {
  switch (fault.kind) {
    case Kind::kProtectiveStop:
      robots_[static_cast<std::size_t>(fault.robot)].trip();
      return {};
    case Kind::kPartMissing:
      if (physics_->body(fault.body).lost_step) return kLost;
      physics_->take_away(fault.body);
      return {};
    case Kind::kPartSwapped:
    case Kind::kPartMisplaced:
    case Kind::kPartUpsideDown:
    case Kind::kPartStray:
      return move_part(fault);
    case Kind::kTrayShifted:
      return shift_tray(fault);
    default:
      return {};  // lasts, or is the wires'
  }
}

std::string World::move_part(const FaultSpec& fault) {
  const physics::BodyState state = physics_->body(fault.body);
  if (state.lost_step) return kLost;
  const Eigen::Isometry3d X_WB = pose_of(state);
  if (fault.kind == Kind::kPartSwapped) {
    const physics::BodyState other = physics_->body(fault.other_body);
    if (other.lost_step) return kLost;
    // Together, out of each other's way; then each again, as low as its own place lets it be.
    const std::array<physics::PhysicsWorld::Placement, 2> both{
        {{fault.body, pose_of(other)}, {fault.other_body, X_WB}}};
    physics_->put(both);
    for (const auto& one : both) physics_->put(std::span(&one, 1));
    return {};
  }
  Eigen::Isometry3d X_new = X_WB;
  if (fault.kind == Kind::kPartUpsideDown) {
    X_new = turned_over(X_WB, description_->bodies[static_cast<std::size_t>(fault.body)]);
  } else if (fault.kind == Kind::kPartMisplaced) {
    X_new = shifted(X_WB, {fault.value("x"), fault.value("y"), 0}, fault.value("yaw"));
  } else {
    X_new.translation() = Eigen::Vector3d(fault.value("x"), fault.value("y"), fault.value("z"));
    X_new.linear().setIdentity();
  }
  const std::array<physics::PhysicsWorld::Placement, 1> one{{{fault.body, X_new}}};
  physics_->put(one);
  return {};
}

std::string World::shift_tray(const FaultSpec& fault) {
  const physics::BodyState state = physics_->body(fault.body);
  if (state.lost_step) return kLost;
  const Eigen::Isometry3d X_WP = pose_of(state);
  const Eigen::Isometry3d X_new =
      shifted(X_WP, {fault.value("x"), fault.value("y"), 0}, fault.value("yaw"));
  std::vector<physics::PhysicsWorld::Placement> moved{{fault.body, X_new}};
  const auto& bodies = description_->bodies;
  const api::BodyDescription& tray = bodies[static_cast<std::size_t>(fault.body)];
  for (int i = 0; i < physics_->body_count(); ++i) {
    if (bodies[static_cast<std::size_t>(i)].kind != api::BodyKind::kGear) continue;
    const physics::BodyState gear = physics_->body(i);
    if (gear.lost_step || !stands_on(pose_of(gear), X_WP, tray)) continue;
    moved.push_back({i, X_new * X_WP.inverse() * pose_of(gear)});
  }
  physics_->put(moved);
  return {};
}

void World::bring_into_effect(const FaultEffects& effects) {
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    robots_[i].set_faults(effects.robots[i]);
    physics_->set_gripper_wear(static_cast<int>(i), effects.robots[i].wear);
    vision_->set_faults(i, effects.cameras[i]);
  }
  if (conveyor_) conveyor_->set_faults(effects.belt);
  if (photo_eyes_) photo_eyes_->set_stuck(effects.photo_eyes);
  for (int i = 0; i < physics_->body_count(); ++i) {
    physics_->set_jammed(i, std::ranges::find(effects.jammed, i) != effects.jammed.end());
  }
  const std::size_t before = intruders_.size();
  gather_intruders(effects.intruders);
  if (before == intruders_.size()) return;
  occluders_->gather(robots_, *physics_, intruders_);
  look_through_curtain();
}

void World::gather_intruders(std::span<const api::Intruder> of_faults) {
  intruders_.clear();
  if (intruder_) intruders_.push_back(*intruder_);
  intruders_.insert(intruders_.end(), of_faults.begin(), of_faults.end());
}

}  // namespace aprsim::world
