#include "world/scene/readers/tool_reader.hpp"

#include "world/scene/model/part_shapes.hpp"
#include "world/scene/readers/reading.hpp"
#include "world/scene/readers/type_reader.hpp"

namespace aprsim::scene {
namespace {

using yaml::kNotNegative;
using yaml::kPositive;

Gripper read_cup(const yaml::Node& node) {
  constexpr double kCubicMetrePerSecondAndLitrePerMinute = 1e-3 / 60;
  const yaml::Map keys =
      node.map({"radius_m", "length_m", "max_vacuum_kpa", "free_flow_l_min", "evacuation_s",
                "lip_compliance_m", "roughness_m", "friction", "body_size_m", "body_mass_kg",
                "mount_mass_kg", "stiffness_n_m", "damping_ns_m"});
  Gripper gripper;
  gripper.law = GripperLaw::kConstant;
  VacuumCup& cup = gripper.cup.emplace();
  cup.radius_m = keys["radius_m"].number(kLength);
  // No vacuum is below none.
  cup.max_vacuum_pa = 1e3 * keys["max_vacuum_kpa"].number({.min = 0, .max = 101, .open_min = true});
  cup.free_flow_m3_s = kCubicMetrePerSecondAndLitrePerMinute *
                       keys["free_flow_l_min"].number({.min = 0, .max = 1e4, .open_min = true});
  cup.evacuation_s = keys["evacuation_s"].number_or(0.02, yaml::between(0, 10));
  cup.lip_compliance_m = keys["lip_compliance_m"].number_or(5e-4, yaml::between(0, 0.01));
  cup.roughness_m = keys["roughness_m"].number_or(5e-6, yaml::between(0, cup.lip_compliance_m));
  gripper.pad_height_m = keys["length_m"].number(kLength);
  gripper.pad_friction = keys["friction"].number_or(0.6, kNotNegative);
  gripper.palm_size = read_xyz(keys["body_size_m"], kLength);
  gripper.palm_mass_kg = keys["body_mass_kg"].number(kPositive);
  gripper.mount_mass_kg = keys["mount_mass_kg"].number_or(0, kNotNegative);
  gripper.palm_stiffness_n_m =
      keys["stiffness_n_m"].number_or(gripper.palm_stiffness_n_m, kPositive);
  gripper.palm_damping_ns_m =
      keys["damping_ns_m"].number_or(gripper.palm_damping_ns_m, kNotNegative);
  return gripper;
}

}  // namespace

Tool read_tool(const yaml::Map& keys) {
  Tool tool;
  const bool cup = keys["kind"].word({"pincher", "vacuum_cup"}) == 1;
  if (const yaml::Node other = keys[cup ? "gripper" : "cup"]) {
    other.error(cup ? "gripper of a vacuum_cup" : "cup of a pincher",
                cup ? "cup in its place" : "gripper in its place");
  }
  tool.gripper = cup ? read_cup(keys["cup"]) : read_gripper(keys["gripper"]);
  const yaml::Map point = keys["tool_point"].map({"xyz_m", "rpy_deg"});
  tool.X_QT = read_pose(point["xyz_m"], point["rpy_deg"]);
  // The palm's box is upright on the approach.
  const Eigen::Vector3d approach = tool.X_QT.q * Eigen::Vector3d::UnitZ();
  if (approach.z() < 1 - 1e-9 || tool.X_QT.p.head<2>().norm() > 1e-9) {
    keys["tool_point"].error("a tool point beside the coupling's axis",
                             "x and y of xyz_m 0, and a turn about z only");
  }
  const double palm_top = tool.gripper.pad_height_m + tool.gripper.palm_size.z();
  if (tool.X_QT.p.z() < palm_top) {
    point["xyz_m"].error(
        "a palm that reaches beyond the coupling",
        "z at least pad_height_m and the palm's height, " + std::to_string(palm_top));
  }
  return tool;
}

ToolChanger read_tool_changer(const yaml::Node& node) {
  ToolChanger changer;
  if (!node) return changer;
  const yaml::Map keys =
      node.map({"xyz_m", "rpy_deg", "mass_kg", "time_s", "capture_m", "capture_deg"});
  changer.X_FQ = read_pose(keys["xyz_m"], keys["rpy_deg"]);
  changer.mass_kg = keys["mass_kg"].number_or(changer.mass_kg, yaml::between(0, 100));
  changer.time_s = keys["time_s"].number_or(changer.time_s, yaml::between(0, 10));
  changer.capture_m = keys["capture_m"].number_or(changer.capture_m, yaml::between(0, 0.02));
  changer.capture_rad = radians(
      keys["capture_deg"].number_or(changer.capture_rad / radians(1), yaml::between(0, 20)));
  return changer;
}

ForceSensor read_force_sensor(const yaml::Node& node) {
  constexpr double kMost_n = 1e4, kMostDrift_n_s = 100, kMostNoise_n = 100;
  ForceSensor sensor;
  if (!node) return sensor;
  const yaml::Map keys = node.map({"bias_n", "drift_n_s", "noise_n"});
  if (const yaml::Node bias = keys["bias_n"]) {
    sensor.bias_n = read_xyz(bias, yaml::between(-kMost_n, kMost_n));
  }
  if (const yaml::Node drift = keys["drift_n_s"]) {
    sensor.drift_n_s = read_xyz(drift, yaml::between(-kMostDrift_n_s, kMostDrift_n_s));
  }
  sensor.noise_n = keys["noise_n"].number_or(0, yaml::between(0, kMostNoise_n));
  return sensor;
}

Holder read_holder(const yaml::Map& keys, const std::string& name) {
  Holder holder;
  holder.name = name;
  holder.X_WQ = read_pose(keys["xyz_m"], keys["rpy_deg"]);
  holder.seat_m = keys["seat_m"].number(kLength);
  const double gap = keys["gap_m"].number(kLength);
  const Eigen::Vector3d bar = read_xyz(keys["bar_m"], kLength);
  const Eigen::AngleAxisd turn(radians(keys["bars_yaw_deg"].number_or(0, yaml::between(-360, 360))),
                               Eigen::Vector3d::UnitZ());
  for (std::size_t i = 0; i < holder.bars.size(); ++i) {
    const double side = i == 0 ? 1 : -1;
    StaticBox& box = holder.bars[i];
    box.name = name + (i == 0 ? "_1" : "_2");
    box.size = bar;
    const Eigen::Translation3d offset(0.5 * side * (gap + bar.x()), 0,
                                      holder.seat_m + 0.5 * bar.z());
    box.X_WS = Pose::from(holder.X_WQ.isometry() * turn * offset);
  }
  return holder;
}

}  // namespace aprsim::scene
