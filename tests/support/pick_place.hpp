#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/cell_script.hpp"

namespace aprsim::test {

/// Motion of the gear during a pick and place, measured every step.
struct PickPlaceReport {
  double lift_m = 0;         ///< highest rise of the gear
  double slip_m = 0;         ///< largest motion of the gear in the hand while carried
  double place_error_m = 0;  ///< gear to slot in the end
  double tilt_rad = 0;       ///< gear's axis to the slot's in the end
  double max_penetration_m = 0;
  bool resting = false;
};

/// Tool pose over a gear: z down, the fingers' direction turned by `yaw` from world x.
inline Eigen::Isometry3d tool_down(const Eigen::Vector3d& p_W, double yaw) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  X.translation() = p_W;
  return X;
}

/// Takes `gear` by its peg and puts it into a slot, as the APRS controllers do: open, above, down,
/// close, up, over, down, open, up.
inline PickPlaceReport pick_and_place(CellScript& cell, int robot, const std::string& gear,
                                      const std::string& tray, const std::string& slot, double yaw,
                                      Eigen::Vector2d offset = {0, 0}) {
  const auto& robot_description = cell.world.description()->robots[static_cast<std::size_t>(robot)];
  const auto& gear_description = cell.world.description()->bodies[cell.body(gear)];
  const Eigen::Isometry3d X_RW =
      (robot_description.X_WB.isometry() * robot_description.X_BR.isometry()).inverse();
  const auto move = [&](const Eigen::Isometry3d& X_WT, bool straight) {
    cell.act(robot, api::MoveTo{Pose::from(X_RW * X_WT), straight});
  };
  const auto speed = [&](double m_s) {
    cell.act(robot, api::SetMotionLimit{api::MotionLimit::kTransSpeed, false, m_s});
  };
  const Eigen::Vector3d up(0, 0, 0.06);
  const double grip_z = gear_description.disc_height_m + 0.004;

  PickPlaceReport report;
  const double start_z = cell.X_WB(gear).translation().z();
  Eigen::Isometry3d X_TG = Eigen::Isometry3d::Identity();
  bool carried = false;
  cell.each_step = [&] {
    const Eigen::Isometry3d X_WG = cell.X_WB(gear);
    report.lift_m = std::max(report.lift_m, X_WG.translation().z() - start_z);
    report.max_penetration_m = std::max(report.max_penetration_m, cell.now.max_penetration_m);
    if (!carried) return;
    const Eigen::Isometry3d X_WT = cell.now.robots[static_cast<std::size_t>(robot)].X_WT.isometry();
    const Eigen::Isometry3d X_now = X_WT.inverse() * X_WG;
    report.slip_m = std::max(report.slip_m, (X_now.translation() - X_TG.translation()).norm());
  };

  cell.act(robot, api::InitRobot{});
  cell.act(robot, api::SetGripper{1});
  speed(0.4);
  Eigen::Vector3d grip = cell.X_WB(gear) * Eigen::Vector3d(offset.x(), offset.y(), grip_z);
  move(tool_down(grip + up, yaw), false);
  speed(0.12);
  move(tool_down(grip, yaw), true);
  cell.act(robot, api::Dwell{std::chrono::milliseconds(50)});
  cell.act(robot, api::SetGripper{0});
  cell.act(robot, api::Dwell{std::chrono::milliseconds(50)});
  move(tool_down(grip + up, yaw), true);
  const auto in_hand = [&] {
    return cell.now.robots[static_cast<std::size_t>(robot)].X_WT.isometry().inverse() *
           cell.X_WB(gear);
  };
  X_TG = in_hand();
  carried = true;
  speed(0.4);
  // The slot's pose for the gear, turned back to the tool by where the gear sits in the hand.
  const Eigen::Vector3d slot_W = cell.X_WS(tray, slot).translation();
  Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
  X_WG.linear() = cell.X_WB(gear).linear();
  X_WG.translation() = slot_W + Eigen::Vector3d(0, 0, 5e-4);
  const Eigen::Isometry3d X_WT = X_WG * X_TG.inverse();
  const Eigen::Vector3d place = X_WT.translation();
  move(tool_down(place + up, yaw), false);
  speed(0.1);
  move(tool_down(place + Eigen::Vector3d(0, 0, 0.014), yaw), true);
  carried = false;
  move(tool_down(place, yaw), true);
  cell.act(robot, api::Dwell{std::chrono::milliseconds(50)});
  cell.act(robot, api::SetGripper{1});
  cell.act(robot, api::Dwell{std::chrono::milliseconds(50)});
  move(tool_down(place + up, yaw), true);
  cell.advance(500);
  cell.each_step = nullptr;
  const Eigen::Isometry3d X_SG = cell.X_WS(tray, slot).inverse() * cell.X_WB(gear);
  report.place_error_m = X_SG.translation().norm();
  report.tilt_rad = std::acos(std::clamp(X_SG.linear()(2, 2), -1.0, 1.0));
  report.resting = cell.now.bodies[cell.body(gear)].resting;
  return report;
}

}  // namespace aprsim::test
