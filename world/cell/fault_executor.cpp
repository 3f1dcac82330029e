#include "world/cell/fault_executor.hpp"

#include <algorithm>
#include <array>
#include <numbers>
#include <vector>

namespace aprsim::world {
namespace {

using faults::Kind;
using Placement = physics::PhysicsWorld::Placement;

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

/// The same by the parameters of a fault.
Eigen::Isometry3d shifted(const Eigen::Isometry3d& X_WB, const FaultSpec& fault) {
  return shifted(X_WB, {fault.value("x"), fault.value("y"), 0}, fault.value("yaw"));
}

/// Turned over in place: its top is as high as its underside was, or lower.
Eigen::Isometry3d turned_over(const Eigen::Isometry3d& X_WB, const scene::FreeBody& gear) {
  Eigen::Isometry3d out = X_WB;
  out.linear() = X_WB.linear() * Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
  const double top = gear.is_part() ? gear.slab.min().z() + gear.slab.max().z()
                                    : std::max(gear.disc_height_m, gear.peg_top_m);
  out.translation() += X_WB.linear().col(2) * top;
  return out;
}

}  // namespace

std::string FaultExecutor::carry_out(const FaultSpec& fault) {
  switch (fault.kind) {
    case Kind::kProtectiveStop:
      parts_.robots[static_cast<std::size_t>(fault.robot)].trip();
      return {};
    case Kind::kPartMissing:
      return remove_part(fault);
    case Kind::kPartSwapped:
      return swap_parts(fault);
    case Kind::kPartMisplaced:
    case Kind::kPartUpsideDown:
    case Kind::kPartStray:
      return move_part(fault);
    case Kind::kTrayShifted:
      return shift_tray(fault);
    default:
      return {};  // lasting faults, and those of the wires
  }
}

void FaultExecutor::put(int body, const Eigen::Isometry3d& X_WB) {
  const std::array<Placement, 1> one{{{body, X_WB}}};
  parts_.physics.place(one);
}

std::string FaultExecutor::remove_part(const FaultSpec& fault) {
  if (parts_.physics.body(fault.body).lost_step) return kLost;
  parts_.physics.remove(fault.body);
  return {};
}

std::string FaultExecutor::swap_parts(const FaultSpec& fault) {
  const physics::BodyState first = parts_.physics.body(fault.body);
  const physics::BodyState second = parts_.physics.body(fault.other_body);
  if (first.lost_step || second.lost_step) return kLost;
  // Both together, clear of each other; then each alone, as low as its new place allows.
  const std::array<Placement, 2> both{
      {{fault.body, pose_of(second)}, {fault.other_body, pose_of(first)}}};
  parts_.physics.place(both);
  for (const auto& one : both) parts_.physics.place(std::span(&one, 1));
  return {};
}

std::string FaultExecutor::move_part(const FaultSpec& fault) {
  const physics::BodyState state = parts_.physics.body(fault.body);
  if (state.lost_step) return kLost;
  const Eigen::Isometry3d X_WB = pose_of(state);
  if (fault.kind == Kind::kPartUpsideDown) {
    const auto& gear = parts_.settings.bodies[static_cast<std::size_t>(fault.body)];
    put(fault.body, turned_over(X_WB, gear));
  } else if (fault.kind == Kind::kPartMisplaced) {
    put(fault.body, shifted(X_WB, fault));
  } else {
    Eigen::Isometry3d X_new = Eigen::Isometry3d::Identity();
    X_new.translation() = Eigen::Vector3d(fault.value("x"), fault.value("y"), fault.value("z"));
    put(fault.body, X_new);
  }
  return {};
}

std::string FaultExecutor::shift_tray(const FaultSpec& fault) {
  const physics::BodyState state = parts_.physics.body(fault.body);
  if (state.lost_step) return kLost;
  const Eigen::Isometry3d X_WP = pose_of(state);
  const Eigen::Isometry3d X_new = shifted(X_WP, fault);
  std::vector<Placement> moved{{fault.body, X_new}};
  // Gears and parts that stand on the tray move with it.
  const auto& bodies = parts_.settings.bodies;
  const scene::FreeBody& tray = bodies[static_cast<std::size_t>(fault.body)];
  for (int i = 0; i < parts_.physics.body_count(); ++i) {
    if (bodies[static_cast<std::size_t>(i)].is_tray()) continue;
    const physics::BodyState gear = parts_.physics.body(i);
    if (gear.lost_step || !scene::stands_on(pose_of(gear), X_WP, tray)) continue;
    moved.push_back({i, X_new * X_WP.inverse() * pose_of(gear)});
  }
  parts_.physics.place(moved);
  return {};
}

void FaultExecutor::apply(const FaultEffects& effects) {
  for (std::size_t i = 0; i < parts_.robots.size(); ++i) {
    parts_.robots[i].set_faults(effects.robots[i]);
    parts_.physics.set_gripper_wear(static_cast<int>(i), effects.robots[i].wear);
    parts_.vision.set_faults(i, effects.cameras[i]);
  }
  if (parts_.conveyor != nullptr) parts_.conveyor->set_faults(effects.belt);
  if (parts_.photo_eyes != nullptr) parts_.photo_eyes->set_stuck(effects.photo_eyes);
  for (int i = 0; i < parts_.physics.body_count(); ++i) {
    parts_.physics.set_decoupled_from_belt(
        i, std::ranges::find(effects.decoupled_from_belt, i) != effects.decoupled_from_belt.end());
  }
}

}  // namespace aprsim::world
