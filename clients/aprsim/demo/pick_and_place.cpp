#include "clients/aprsim/demo/pick_and_place.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/demo/geometry.hpp"
#include "clients/aprsim/demo/grasp.hpp"

namespace aprsim::client {

namespace {

constexpr double kFast_m_s = 0.4, kSlow_m_s = 0.1;
constexpr double kApproach_m = 0.08;      // height over the grasp or place pose
constexpr double kPlaceAbove_m = 0.0005;  // height of the release over the slot
constexpr double kDwell_s = 0.05;
constexpr double kLifted_m = 0.04;
constexpr double kPlaced_m = 0.001;
constexpr double kUpright_rad = 0.02;
constexpr double kMaxGraspSlip_m = 0.001;
constexpr auto kGripTimeout = std::chrono::seconds(3);
constexpr auto kRestTimeout = std::chrono::seconds(8);
constexpr double kDegPerRad = 180 / std::numbers::pi;

const v1::RobotState* robot_in(const v1::Snapshot& snapshot, const std::string& name) {
  const auto found = std::ranges::find(snapshot.robots(), name, &v1::RobotState::name);
  return found == snapshot.robots().end() ? nullptr : &*found;
}

/// Recognises the robot's message for a position out of reach. For other messages all yaws are
/// tried.
bool says_out_of_reach(const Failure& refusal) {
  return refusal.message.find("out of reach") != std::string::npos;
}

}  // namespace

PickAndPlace::PickAndPlace(DemoCell& cell, Arm& arm, Transfer transfer)
    : cell_(cell), arm_(arm), transfer_(std::move(transfer)) {
  p_grasp_WT_ = transfer_.gear.X_WP.translation();
  p_grasp_WT_.z() += grasp_height_m(transfer_.gear.geometry);
}

void PickAndPlace::say(const char* event, const std::string& text,
                       nlohmann::ordered_json fields) const {
  nlohmann::ordered_json all{{"gear", transfer_.gear.name}};
  all.update(fields);
  cell_.report(arm_.name(), event, text, all);
}

Outcome<void> PickAndPlace::run() {
  say("transfer",
      fmt::format("{} from {} to {}", transfer_.gear.name, transfer_.from.name(),
                  transfer_.to.name()),
      {{"from", transfer_.from.name()}, {"to", transfer_.to.name()}});
  for (const auto step : {&PickAndPlace::reach_for_gear, &PickAndPlace::pick, &PickAndPlace::lift,
                          &PickAndPlace::carry_and_place}) {
    if (auto done = (this->*step)(); !done) return done;
  }
  return {};
}

/// Moves over a point with the first reachable yaw. With a tool that points down, the wrist is in
/// the same place at every yaw: if that is out of reach, no other yaw is tried.
Outcome<void> PickAndPlace::approach(const Eigen::Vector3d& p_WT) {
  const Eigen::Vector3d above = p_WT + Eigen::Vector3d(0, 0, kApproach_m);
  Outcome<void> done = failed(FailureKind::kRefused, arm_.name() + ": no yaw to try");
  for (const double yaw : yaws_) {
    yaw_rad_ = yaw;
    done = arm_.move(tool_down(above, yaw), /*straight=*/false);
    if (done || done.error().kind != FailureKind::kRefused) return done;
    if (auto cleared = arm_.initialise(); !cleared) return cleared;
    if (says_out_of_reach(done.error())) return done;
  }
  return done;
}

/// Moves on a straight line, which keeps the gear level, or on any path if the arm cannot follow
/// the line.
Outcome<void> PickAndPlace::move_level(const Eigen::Isometry3d& X_WT) {
  auto done = arm_.move(X_WT, /*straight=*/true);
  if (done || done.error().kind != FailureKind::kRefused) return done;
  if (auto cleared = arm_.initialise(); !cleared) return cleared;
  return arm_.move(X_WT, /*straight=*/false);
}

Outcome<void> PickAndPlace::reach_for_gear() {
  const auto snapshot = cell_.connection.snapshot();
  if (!snapshot) return tl::unexpected(snapshot.error());
  const auto* robot = robot_in(*snapshot, arm_.name());
  if (robot == nullptr) return failed(FailureKind::kCheck, "the snapshot has no " + arm_.name());
  if (robot->gripper().holding()) {
    return failed(FailureKind::kCheck, arm_.name() + " still holds " +
                                           robot->gripper().held_body() +
                                           "; 'aprsim reset' restarts the cell");
  }
  yaws_ = rank_yaws(CellView(cell_.description, *snapshot), transfer_, arm_.description().gripper(),
                    tool_yaw(arm_.X_WT(*robot)));
  if (auto done = arm_.set_gripper(true); !done) return done;
  if (auto done = arm_.set_speed(kFast_m_s); !done) return done;
  if (auto done = approach(p_grasp_WT_); !done) {
    if (done.error().kind == FailureKind::kRefused) {
      refusal_ = {transfer_.from, says_out_of_reach(done.error())};
    }
    return done;
  }
  say("over",
      fmt::format("over {}, tool turned to {:.0f} deg", transfer_.gear.name, yaw_rad_ * kDegPerRad),
      {{"yaw_rad", yaw_rad_}});
  return {};
}

Outcome<void> PickAndPlace::pick() {
  if (auto done = arm_.set_speed(kSlow_m_s); !done) return done;
  if (auto done = arm_.move(tool_down(p_grasp_WT_, yaw_rad_), true); !done) return done;
  if (auto done = arm_.dwell(kDwell_s); !done) return done;
  if (auto done = arm_.set_gripper(false); !done) return done;
  if (auto done = arm_.dwell(kDwell_s); !done) return done;
  return await_grip();
}

Outcome<void> PickAndPlace::await_grip() {
  v1::GripperState gripper;
  const auto held = cell_.wait_until(
      [&](const v1::Snapshot& snapshot) {
        const auto* robot = robot_in(snapshot, arm_.name());
        if (robot != nullptr) gripper = robot->gripper();
        return gripper.holding() && gripper.held_body() == transfer_.gear.name;
      },
      kGripTimeout);
  if (!held) return tl::unexpected(held.error());
  // Fingers without a reported force have none.
  const double first_N = gripper.force_n_size() > 0 ? gripper.force_n(0) : 0;
  const double second_N = gripper.force_n_size() > 1 ? gripper.force_n(1) : 0;
  if (!*held) {
    return failed(FailureKind::kCheck,
                  fmt::format("{}: the gripper closed but does not hold {} (fingers {:.2f} mm "
                              "apart, {:.1f} and {:.1f} N)",
                              arm_.name(), transfer_.gear.name, 1e3 * gripper.separation_m(),
                              first_N, second_N));
  }
  say("holds",
      fmt::format("holds {} with {:.1f} and {:.1f} N, fingers {:.2f} mm apart", gripper.held_body(),
                  first_N, second_N, 1e3 * gripper.separation_m()),
      {{"force_N", {first_N, second_N}}, {"separation_m", gripper.separation_m()}});
  return {};
}

Outcome<Eigen::Isometry3d> PickAndPlace::gear_in_tool(const char* when) const {
  const auto snapshot = cell_.connection.snapshot();
  if (!snapshot) return tl::unexpected(snapshot.error());
  const auto* robot = robot_in(*snapshot, arm_.name());
  const CellView view(cell_.description, *snapshot);
  const auto* gear = view.gear(transfer_.gear.name);
  if (robot == nullptr || gear == nullptr || !robot->gripper().holding()) {
    return failed(FailureKind::kCheck,
                  fmt::format("{} lost {} {}", arm_.name(), transfer_.gear.name, when));
  }
  return arm_.X_WT(*robot).inverse() * gear->X_WP;
}

Outcome<void> PickAndPlace::lift() {
  const Eigen::Vector3d above = p_grasp_WT_ + Eigen::Vector3d(0, 0, kApproach_m);
  if (auto done = arm_.move(tool_down(above, yaw_rad_), true); !done) return done;
  const auto X_TP = gear_in_tool("while lifting");
  if (!X_TP) return tl::unexpected(X_TP.error());
  X_TP_ = *X_TP;
  const auto view = cell_.view();
  if (!view) return tl::unexpected(view.error());
  const double lifted = view->gear(transfer_.gear.name)->X_WP.translation().z() -
                        transfer_.gear.X_WP.translation().z();
  if (lifted < kLifted_m) {
    return failed(FailureKind::kCheck, fmt::format("{}: {} was lifted by {:.1f} mm only",
                                                   arm_.name(), transfer_.gear.name, 1e3 * lifted));
  }
  say("lifted", fmt::format("lifted it by {:.1f} mm", 1e3 * lifted), {{"lift_m", lifted}});
  return {};
}

Outcome<void> PickAndPlace::carry_and_place() {
  if (auto carried = carry(); !carried) {
    return carried.error().kind == FailureKind::kRefused ? put_back(carried.error()) : carried;
  }
  if (auto done = place(transfer_.to); !done) return done;
  return check_place(transfer_.to);
}

Outcome<void> PickAndPlace::put_back(const Failure& reason) {
  // The message begins with the robot's name, as a line of the demo does.
  const std::string name = arm_.name() + ": ";
  const std::string why =
      reason.message.starts_with(name) ? reason.message.substr(name.size()) : reason.message;
  say("refused", why, {{"reason", why}});
  say("puts_back", fmt::format("puts it back into {}", transfer_.from.name()),
      {{"to", transfer_.from.name()}});
  if (auto cleared = arm_.initialise(); !cleared) return cleared;
  if (auto done = place(transfer_.from); !done) return done;
  if (auto done = check_place(transfer_.from); !done) return done;
  refusal_ = {transfer_.to, says_out_of_reach(reason)};
  return tl::unexpected(reason);
}

Outcome<void> PickAndPlace::carry() {
  if (auto done = arm_.set_speed(kFast_m_s); !done) return done;
  const Eigen::Vector3d above =
      transfer_.to.X_WS.translation() +
      Eigen::Vector3d(0, 0, kApproach_m + grasp_height_m(transfer_.gear.geometry));
  auto moved = move_level(tool_down(above, yaw_rad_));
  if (!moved && moved.error().kind == FailureKind::kRefused) {
    if (auto cleared = arm_.initialise(); !cleared) return cleared;
    moved = approach(above - Eigen::Vector3d(0, 0, kApproach_m));
  }
  if (!moved) return moved;
  const auto X_TP = gear_in_tool("on the way");
  if (!X_TP) return tl::unexpected(X_TP.error());
  const double slip = (X_TP->translation() - X_TP_.translation()).norm();
  if (slip > kMaxGraspSlip_m) {
    return failed(FailureKind::kCheck, fmt::format("{}: {} slipped by {:.2f} mm on the way",
                                                   arm_.name(), transfer_.gear.name, 1e3 * slip));
  }
  X_TP_ = *X_TP;
  say("carried", fmt::format("carried it over {}, slip {:.4f} mm", transfer_.to.name(), 1e3 * slip),
      {{"to", transfer_.to.name()}, {"slip_m", slip}});
  return {};
}

Outcome<void> PickAndPlace::place(const SlotView& target) {
  const auto view = cell_.view();
  if (!view) return tl::unexpected(view.error());
  const auto* slot = view->slot(target.tray, target.slot);
  // Corrects the tool pose by the gear's offset in the gripper.
  Eigen::Isometry3d X_WT = tool_down(Eigen::Vector3d::Zero(), yaw_rad_);
  X_WT.translation() = slot->X_WS.translation() + Eigen::Vector3d(0, 0, kPlaceAbove_m) -
                       X_WT.linear() * X_TP_.translation();
  Eigen::Isometry3d X_above = X_WT;
  X_above.translation().z() += kApproach_m;
  if (auto done = arm_.set_speed(kSlow_m_s); !done) return done;
  if (auto done = move_level(X_above); !done) return done;
  if (auto done = arm_.move(X_WT, true); !done) return done;
  if (auto done = arm_.dwell(kDwell_s); !done) return done;
  if (auto done = arm_.set_gripper(true); !done) return done;
  if (auto done = arm_.dwell(4 * kDwell_s); !done) return done;
  return arm_.move(X_above, true);
}

Outcome<void> PickAndPlace::check_place(const SlotView& target) {
  double off = 0, tilt = 0;
  bool resting = false;
  const auto placed = cell_.wait_until(
      [&](const v1::Snapshot& snapshot) {
        const CellView view(cell_.description, snapshot);
        const auto* gear = view.gear(transfer_.gear.name);
        const auto* slot = view.slot(target.tray, target.slot);
        const Eigen::Isometry3d X_SP = slot->X_WS.inverse() * gear->X_WP;
        off = X_SP.translation().norm();
        tilt = std::acos(std::clamp(X_SP.linear()(2, 2), -1.0, 1.0));
        resting = gear->resting;
        return resting && off <= kPlaced_m && tilt <= kUpright_rad;
      },
      kRestTimeout);
  if (!placed) return tl::unexpected(placed.error());
  if (!*placed) {
    return failed(FailureKind::kCheck,
                  fmt::format("{}: {} is {} {:.3f} mm off {} and tilted by {:.2f} deg", arm_.name(),
                              transfer_.gear.name, resting ? "at rest" : "moving", 1e3 * off,
                              target.name(), tilt * kDegPerRad));
  }
  say("rests",
      fmt::format("{} rests in {}, {:.3f} mm off", transfer_.gear.name, target.name(), 1e3 * off),
      {{"to", target.name()}, {"off_m", off}});
  return {};
}

}  // namespace aprsim::client
