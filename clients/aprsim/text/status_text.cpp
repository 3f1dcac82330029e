#include "clients/aprsim/text/status_text.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace aprsim::client {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kMillimetres = 1e3;

/// To one decimal, and never -0.
double tenths(double value) { return std::round(10 * value) / 10 + 0.0; }

std::string point_mm(const v1::Vector3& point) {
  return fmt::format("{:.1f} {:.1f} {:.1f}", tenths(point.x() * kMillimetres),
                     tenths(point.y() * kMillimetres), tenths(point.z() * kMillimetres));
}

/// Rotation about z of a body that lies flat.
double yaw_degrees(const v1::Quaternion& q) {
  const double yaw =
      std::atan2(2 * (q.w() * q.z() + q.x() * q.y()), 1 - 2 * (q.y() * q.y() + q.z() * q.z()));
  return tenths(yaw * kDegrees);
}

std::string action_text(const v1::RobotState& robot, const Paint& paint) {
  if (robot.protective_stop()) {
    return paint(Tone::kBad, "protective stop: " + robot.action().description());
  }
  switch (robot.action().state()) {
    case v1::ACTION_STATE_WORKING:
      return paint(Tone::kWarning, "working");
    case v1::ACTION_STATE_DONE:
      return paint(Tone::kGood, "done");
    case v1::ACTION_STATE_ERROR:
      return paint(Tone::kBad, "error: " + robot.action().description());
    default:
      return robot.initialized() ? paint(Tone::kGood, "ready") : "not ready";
  }
}

std::string gripper_text(const v1::GripperState& gripper) {
  std::string out = fmt::format("{}, {:.2f} mm apart", gripper.setting() > 0.5 ? "open" : "closed",
                                gripper.separation_m() * kMillimetres);
  if (gripper.force_n_size() == 2) {
    out += fmt::format(", {:.1f} / {:.1f} N", gripper.force_n(0), gripper.force_n(1));
  }
  if (gripper.holding()) out += ", holding " + gripper.held_body();
  return out;
}

/// Degrees, or millimetres of joints that slide, which have their unit.
std::string joints_text(const v1::RobotState& robot, const v1::CellDescription& cell) {
  const auto described =
      std::ranges::find(cell.robots(), robot.name(), &v1::RobotDescription::name);
  std::string joints;
  for (int i = 0; i < robot.joints_size(); ++i) {
    const double position = robot.joints(i).position_rad();
    const bool slides = described != cell.robots().end() && i < described->joints_size() &&
                        described->joints(i).prismatic();
    joints += slides ? fmt::format(" {:.2f} mm", position * kMillimetres)
                     : fmt::format(" {:.2f}", position * kDegrees);
  }
  return joints;
}

std::string robot_text(const v1::RobotState& robot, const v1::CellDescription& cell,
                       const Paint& paint) {
  return fmt::format("{}\n  state    {}{}\n  joints   [deg]{}\n  tool     [mm] {}\n  gripper  {}\n",
                     paint(Tone::kHeading, robot.name()), action_text(robot, paint),
                     robot.drives_on() ? "" : ", drives off", joints_text(robot, cell),
                     point_mm(robot.tool_in_reference().position_m()),
                     gripper_text(robot.gripper()));
}

std::string pace_text(const v1::Snapshot& snapshot, const Paint& paint) {
  if (!snapshot.world_fault().empty()) {
    return paint(Tone::kBad, "stopped: " + snapshot.world_fault());
  }
  if (snapshot.paused()) return paint(Tone::kWarning, "paused");
  const std::string target = snapshot.has_speed_target()
                                 ? fmt::format("{:g}", snapshot.speed_target())
                                 : "as fast as possible";
  return fmt::format("{:.2f} x real time (target {}), {} steps missed", snapshot.real_time_factor(),
                     target, snapshot.missed_steps());
}

std::string joined(const google::protobuf::RepeatedPtrField<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

/// A line on virtual time.
std::string virtual_time_text(const v1::VirtualTime& time, const Paint& paint) {
  std::string out = "  virtual  ";
  if (!time.paced()) {
    out += paint(Tone::kWarning, "no client advances it: it follows the wall clock");
  } else if (time.awaited_size() > 0) {
    out += paint(Tone::kWarning, "waits for " + joined(time.awaited()));
  } else {
    out += time.pacers_size() > 0 ? "paced by " + joined(time.pacers()) : "stands";
  }
  if (!time.reproducible()) {
    out += fmt::format("; not reproducible: followed the wall clock {} times, dropped {} clients",
                       time.fallbacks(), time.expired());
  }
  return out + "\n";
}

std::string belt_text(const v1::ConveyorState& conveyor, const Paint& paint) {
  return fmt::format(
      "{}\n  drive    {}, {}, set {:.4f} m/s\n  belt     {:+.4f} m/s, {:+.4f} m run\n",
      paint(Tone::kHeading, "conveyor"), conveyor.run() ? "running" : "stopped",
      conveyor.forward() ? "forward" : "reverse", conveyor.speed_setting_m_s(),
      conveyor.speed_m_s(), conveyor.travel_m());
}

std::string light_curtain_text(const v1::LightCurtainState& curtain, const Paint& paint) {
  std::string out = curtain.broken() ? paint(Tone::kWarning, "broken") : "clear";
  if (curtain.distance_m_size() > 0) {
    const auto nearest = std::ranges::min_element(curtain.distance_m());
    out += fmt::format(", nearest {:.3f} m in {} beams", *nearest, curtain.distance_m_size());
  }
  return paint(Tone::kHeading, "light curtain") + "\n  " + out + "\n";
}

std::string devices_text(const v1::Snapshot& snapshot, const Paint& paint) {
  if (snapshot.devices().empty()) return {};
  std::string out = paint(Tone::kHeading, "devices") + "\n";
  for (const auto& device : snapshot.devices()) {
    out += fmt::format("  {:<8}", device.name());
    for (const auto& signal : device.signals()) {
      out += fmt::format(" {} {:.6g}", signal.name(), signal.value());
    }
    if (!device.fault().empty()) out += " " + paint(Tone::kBad, "failed: " + device.fault());
    out += "\n";
  }
  return out;
}

}  // namespace

double seconds(const google::protobuf::Duration& span) {
  return static_cast<double>(span.seconds()) + 1e-9 * span.nanos();
}

std::string status_text(const v1::Snapshot& snapshot, const v1::CellDescription& cell,
                        const Paint& paint) {
  std::string out = fmt::format(
      "{}\n  time     {:.3f} s, step {}, epoch {}\n  pace     {}\n  step     {:.3f} ms mean\n"
      "  contacts {}, deepest {:.3f} mm, {} physics faults, {} virtual joints\n",
      paint(Tone::kHeading, "cell"), seconds(snapshot.sim_time()), snapshot.step(),
      snapshot.epoch(), pace_text(snapshot, paint), seconds(snapshot.step_time()) * 1e3,
      snapshot.contact_count(), snapshot.max_penetration_m() * kMillimetres,
      snapshot.physics_faults(), snapshot.virtual_joint_count());
  if (snapshot.has_virtual_time()) out += virtual_time_text(snapshot.virtual_time(), paint);
  for (const auto& robot : snapshot.robots()) out += robot_text(robot, cell, paint);
  if (snapshot.has_conveyor()) out += belt_text(snapshot.conveyor(), paint);
  if (snapshot.has_light_curtain()) out += light_curtain_text(snapshot.light_curtain(), paint);
  out += devices_text(snapshot, paint);
  const auto resting = std::ranges::count_if(snapshot.bodies(), &v1::BodyState::resting);
  out += fmt::format("{}\n  {} in all, {} at rest\n", paint(Tone::kHeading, "bodies"),
                     snapshot.bodies_size(), resting);
  return out;
}

std::string bodies_text(const v1::Snapshot& snapshot) {
  std::string out;
  for (const auto& body : snapshot.bodies()) {
    out += fmt::format("  {:<28} [mm] {} yaw {:.1f} deg{}\n", body.name(),
                       point_mm(body.body_in_world().position_m()),
                       yaw_degrees(body.body_in_world().orientation()),
                       body.has_lost_step() ? ", lost"
                       : body.resting()     ? ""
                                            : ", moving");
  }
  return out;
}

std::string watch_line(const v1::Snapshot& snapshot, std::uint64_t dropped, const Paint& paint) {
  std::string out =
      fmt::format("{:.3f} s x{:.2f}", seconds(snapshot.sim_time()), snapshot.real_time_factor());
  for (const auto& robot : snapshot.robots()) {
    out += fmt::format("  {} {} [{}]{}", robot.name(), action_text(robot, paint),
                       point_mm(robot.tool_in_reference().position_m()),
                       robot.gripper().holding() ? " holding " + robot.gripper().held_body() : "");
  }
  if (snapshot.has_conveyor()) {
    out += fmt::format("  belt {:+.3f} m/s", snapshot.conveyor().speed_m_s());
  }
  const std::string lost = dropped_text(dropped);
  return lost.empty() ? out + "\n" : out + "  " + lost;
}

std::string dropped_text(std::uint64_t dropped) {
  return dropped > 0 ? fmt::format("({} samples lost)\n", dropped) : "";
}

}  // namespace aprsim::client
