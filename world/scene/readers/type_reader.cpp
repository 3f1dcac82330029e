#include "world/scene/readers/type_reader.hpp"

#include <cmath>
#include <filesystem>

#include "world/scene/checks/type_checks.hpp"
#include "world/scene/readers/piece_reader.hpp"
#include "world/scene/readers/pocket_reader.hpp"
#include "world/scene/readers/reading.hpp"

namespace aprsim::scene {
namespace {

using yaml::kNotNegative;
using yaml::kPositive;

constexpr double kMaxRelaxation = 0.95, kLeastRelaxation_s = 0.01;
constexpr yaml::Range kAcute{.min = 0, .max = 90, .open_min = true, .open_max = true};

/// True if the name is free; else an error.
template <typename T>
bool is_new(const yaml::Node& node, const std::string& name, const std::map<std::string, T>& map) {
  check_name(node, name);
  if (!map.contains(name)) return true;
  node.error("a second definition", "one definition of " + name);
  return false;
}

GearType read_gear_type(const yaml::Node& node, const std::string& name) {
  const yaml::Map keys = node.map({"disc", "hub", "peg", "teeth_outer_radius_m", "mass_kg"});
  const yaml::Map disc = keys["disc"].map({"radius_m", "height_m"});
  const yaml::Map hub =
      keys["hub"].map({"top_radius_m", "bottom_radius_m", "height_m", "chamfer_m"});
  const yaml::Map peg = keys["peg"].map({"radius_m", "height_m"});
  GearType type;
  type.name = name;
  type.disc_radius_m = disc["radius_m"].number(kLength);
  type.disc_height_m = disc["height_m"].number(kLength);
  type.hub_top_radius_m = hub["top_radius_m"].number(kLength);
  type.hub_bottom_radius_m = hub["bottom_radius_m"].number(kLength);
  type.hub_height_m = hub["height_m"].number(kLength);
  type.hub_chamfer_m = hub["chamfer_m"].number_or(0, kNotNegative);
  type.peg_radius_m = peg["radius_m"].number(kLength);
  type.peg_top_m = type.disc_height_m + peg["height_m"].number(kLength);
  type.teeth_outer_radius_m = keys["teeth_outer_radius_m"].number_or(type.disc_radius_m, kPositive);
  type.mass_kg = keys["mass_kg"].number(kPositive);
  check_gear_type(node, type);
  return type;
}

Slot read_slot(const yaml::Node& node, const Types& types) {
  const yaml::Map keys = node.map({"name", "gear", "pocket", "xy_m", "yaw_deg"});
  Slot slot;
  slot.name = read_name(keys["name"]);
  slot.gear_type = keys["gear"].text();
  if (!types.gears.contains(slot.gear_type) && !types.parts.contains(slot.gear_type)) {
    std::vector<std::string> known = keys_of(types.gears);
    for (const auto& [name, type] : types.parts) known.push_back(name);
    report_unknown(keys["gear"], slot.gear_type,
                   types.parts.empty() ? "gear type" : "gear or part type", known);
  }
  if (const auto* pocket = read_reference(keys["pocket"], "pocket", types.pockets)) {
    slot.pocket = *pocket;
  }
  slot.xy = read_xy(keys["xy_m"]);
  slot.yaw_rad = radians(keys["yaw_deg"].number_or(0, yaml::between(-360, 360)));
  return slot;
}

/// The rectangle's corners, if the polygon is one along x and y.
bool is_rectangle(const std::vector<Eigen::Vector2d>& corners) {
  if (corners.size() != 4) return false;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d side = corners[(i + 1) % 4] - corners[i];
    if (side.x() != 0 && side.y() != 0) return false;
  }
  return true;
}

/// The slab as a rectangle of two corners, or as the polygon of `outline_m`.
void read_slab(const yaml::Map& keys, TrayType& type) {
  if (const yaml::Node outline = keys["outline_m"]) {
    for (const char* key : {"min_xy_m", "max_xy_m"}) {
      if (const yaml::Node node = keys[key])
        node.error("min_xy_m, max_xy_m and outline_m", "outline_m alone");
    }
    std::vector<Eigen::Vector2d> corners;
    for (const yaml::Node& item : outline.items()) corners.push_back(read_xy(item));
    if (!check_outline(outline, corners)) return;
    type.min_xy = type.max_xy = corners.front();
    for (const Eigen::Vector2d& corner : corners) {
      type.min_xy = type.min_xy.cwiseMin(corner);
      type.max_xy = type.max_xy.cwiseMax(corner);
    }
    if (!is_rectangle(corners)) type.outline = outline_of(std::move(corners));
    return;
  }
  type.min_xy = read_xy(keys["min_xy_m"]);
  type.max_xy = read_xy(keys["max_xy_m"]);
  if ((type.max_xy.array() <= type.min_xy.array()).any()) {
    keys["max_xy_m"].error("a corner not beyond min_xy_m", "x and y larger than those of min_xy_m");
  }
}

std::optional<LabelRecess> read_label(const yaml::Node& node, double thickness_m) {
  if (!node) return std::nullopt;
  const yaml::Map keys = node.map({"size_m", "depth_m"});
  return LabelRecess{
      .size_m = keys["size_m"].number(kLength),
      .depth_m = keys["depth_m"].number({.min = 0, .max = thickness_m, .open_max = true})};
}

TrayType read_tray_type(const yaml::Node& node, const std::string& name, const Types& types) {
  const yaml::Map keys = node.map(
      {"kind", "min_xy_m", "max_xy_m", "outline_m", "thickness_m", "mass_kg", "label", "slots"});
  TrayType type;
  type.name = name;
  type.kind = keys["kind"].word({"part_tray", "kit_tray"}) == 0 ? api::BodyKind::kPartTray
                                                                : api::BodyKind::kKitTray;
  read_slab(keys, type);
  type.thickness_m = keys["thickness_m"].number(kLength);
  type.mass_kg = keys["mass_kg"].number(kPositive);
  type.label = read_label(keys["label"], type.thickness_m);
  if (type.label) check_label(keys["label"], type);
  const std::vector<yaml::Node> items = keys["slots"].items();
  for (const yaml::Node& item : items) {
    Slot slot = read_slot(item, types);
    for (const Slot& other : type.slots) {
      if (other.name == slot.name) {
        item.error("a second slot " + slot.name, "unique slot names");
      }
    }
    type.slots.push_back(std::move(slot));
  }
  check_tray_type(items, type, types.gears);
  return type;
}

void read_gaps(const yaml::Map& keys, Gripper& gripper) {
  gripper.stroke_m = keys["stroke_m"].number(kLength);
  gripper.gap_closed_m = keys["gap_closed_m"].number(kNotNegative);
  gripper.gap_open_m = keys["gap_open_m"].number(yaml::above(gripper.gap_closed_m));
  const double travel = (gripper.gap_open_m - gripper.gap_closed_m) / 2;
  if (std::abs(travel - gripper.stroke_m) > 1e-6) {
    keys["stroke_m"].unexpected("half of gap_open_m - gap_closed_m, " + std::to_string(travel));
  }
}

/// Each finger's piston: force of the air, friction, and how fast its
/// chambers fill and how they leak.
void read_pneumatics(const yaml::Node& node, Gripper& gripper) {
  constexpr double kNewtonPerBarAndSquareMillimetre = 0.1;
  const yaml::Map air =
      node.map({"supply_bar", "piston_area_mm2", "friction_n", "fill_time_s", "leak_per_s"});
  const double supply_bar = air["supply_bar"].number({.min = 0, .max = 20, .open_min = true});
  const double gross_n = kNewtonPerBarAndSquareMillimetre * supply_bar *
                         air["piston_area_mm2"].number({.min = 0, .max = 1e4, .open_min = true});
  gripper.friction_n = air["friction_n"].number_or(0, kNotNegative);
  gripper.force_n = gross_n - gripper.friction_n;
  if (gripper.force_n <= 0) {
    air["friction_n"].error("a friction of " + std::to_string(gripper.friction_n) + " N",
                            "less than the piston's force of " + std::to_string(gross_n) + " N");
  }
  gripper.fill_time_s = air["fill_time_s"].number_or(0, yaml::between(0, 1));
  gripper.leak_per_s = air["leak_per_s"].number_or(0, yaml::between(0, 1000));
  if (gripper.leak_per_s > 0 && gripper.fill_time_s == 0) {
    air["leak_per_s"].error("a leak without fill_time_s",
                            "fill_time_s above 0: a chamber that fills at once never loses air");
  }
}

/// Reads the force or the values that give it.
void read_force(const yaml::Map& keys, Gripper& gripper) {
  const yaml::Node air = keys["pneumatics"];
  if (!air) {
    gripper.force_n = keys["force_n"].number(kPositive);
  } else if (keys["force_n"]) {
    keys["force_n"].error("force_n beside pneumatics", "one of the two");
  } else {
    read_pneumatics(air, gripper);
  }
}

MimicPid read_mimic_pid(const yaml::Node& node) {
  const yaml::Map keys = node.map({"p_n_m", "i_n_ms", "d_ns_m", "max_n"});
  MimicPid pid;
  pid.p_n_m = keys["p_n_m"].number_or(pid.p_n_m, kNotNegative);
  pid.i_n_ms = keys["i_n_ms"].number_or(pid.i_n_ms, kNotNegative);
  pid.d_ns_m = keys["d_ns_m"].number_or(pid.d_ns_m, kNotNegative);
  pid.max_n = keys["max_n"].number_or(pid.max_n, kPositive);
  return pid;
}

void read_drive(const yaml::Map& keys, Gripper& gripper) {
  if (keys["drive"].word_or(0, {"pneumatic", "servo"}) == 0) return;
  gripper.drive = GripperDrive::kServo;
  if (gripper.law == GripperLaw::kCoupled || gripper.law == GripperLaw::kMimicPid) {
    keys["drive"].error("a servo with a law of pistons", "law linkage or constant with it");
  }
  if (keys["pneumatics"]) keys["pneumatics"].error("pneumatics of a servo", "force_n with it");
}

std::string find_model(const yaml::Node& node, const FileScope& scope) {
  const std::string name = node.text();
  std::string path = scope.find_model(name);
  if (path.empty()) {
    node.error("no file \"" + name + '"', scope.expected_model(), ErrorCode::kNotFound);
  }
  return path;
}

Robot read_robot_type(const yaml::Node& node, const FileScope& scope) {
  const yaml::Map keys = node.map({"model", "tool", "home_deg", "limits", "gripper"});
  Robot robot;
  robot.model_file = find_model(keys["model"], scope);
  const yaml::Map tool = keys["tool"].map({"xyz_m", "rpy_deg"});
  robot.X_FT = read_pose(tool["xyz_m"], tool["rpy_deg"]);
  robot.home_rad = read_joints(keys["home_deg"]);
  const yaml::Map limits = keys["limits"].map(
      {"trans_speed_m_s", "trans_accel_m_s2", "rot_speed_rad_s", "rot_accel_rad_s2"});
  robot.max_trans_speed_m_s = limits["trans_speed_m_s"].number(kPositive);
  robot.max_trans_accel_m_s2 = limits["trans_accel_m_s2"].number(kPositive);
  robot.max_rot_speed_rad_s = limits["rot_speed_rad_s"].number(kPositive);
  robot.max_rot_accel_rad_s2 = limits["rot_accel_rad_s2"].number(kPositive);
  robot.gripper = read_gripper(keys["gripper"]);
  return robot;
}

}  // namespace

Gripper read_gripper(const yaml::Node& node) {
  const yaml::Map keys = node.map({"law",
                                   "drive",
                                   "stroke_m",
                                   "gap_closed_m",
                                   "gap_open_m",
                                   "force_n",
                                   "pneumatics",
                                   "finger_speed_m_s",
                                   "coupling_n_m",
                                   "mimic_pid",
                                   "pad",
                                   "pad_height_m",
                                   "pad_width_m",
                                   "pad_depth_m",
                                   "v_half_angle_deg",
                                   "v_depth_m",
                                   "finger_mass_kg",
                                   "palm_mass_kg",
                                   "mount_mass_kg",
                                   "palm_size_m",
                                   "palm_stiffness_n_m",
                                   "palm_damping_ns_m",
                                   "palm_relaxation",
                                   "pad_friction"});
  Gripper gripper;
  constexpr GripperLaw kLaws[] = {GripperLaw::kLinkage, GripperLaw::kCoupled, GripperLaw::kMimicPid,
                                  GripperLaw::kConstant};
  gripper.law = kLaws[keys["law"].word_or(0, {"linkage", "coupled", "mimic_pid", "constant"})];
  read_drive(keys, gripper);
  read_gaps(keys, gripper);
  read_force(keys, gripper);
  gripper.finger_speed_m_s = keys["finger_speed_m_s"].number(kPositive);
  if (keys["mimic_pid"]) gripper.mimic = read_mimic_pid(keys["mimic_pid"]);
  gripper.coupling_n_m = keys["coupling_n_m"].number_or(gripper.coupling_n_m, kPositive);
  gripper.pad = keys["pad"].word_or(0, {"v", "flat"}) == 0 ? PadShape::kV : PadShape::kFlat;
  gripper.pad_height_m = keys["pad_height_m"].number(kLength);
  gripper.pad_width_m = keys["pad_width_m"].number(kLength);
  gripper.pad_depth_m = keys["pad_depth_m"].number(kLength);
  gripper.v_half_angle_rad = radians(keys["v_half_angle_deg"].number_or(45, kAcute));
  gripper.v_depth_m = keys["v_depth_m"].number_or(0, yaml::between(0, gripper.pad_depth_m));
  gripper.finger_mass_kg = keys["finger_mass_kg"].number(kPositive);
  gripper.palm_mass_kg = keys["palm_mass_kg"].number(kPositive);
  gripper.mount_mass_kg = keys["mount_mass_kg"].number_or(0, kNotNegative);
  gripper.palm_size = read_xyz(keys["palm_size_m"], kLength);
  gripper.palm_stiffness_n_m =
      keys["palm_stiffness_n_m"].number_or(gripper.palm_stiffness_n_m, kPositive);
  gripper.palm_damping_ns_m =
      keys["palm_damping_ns_m"].number_or(gripper.palm_damping_ns_m, kNotNegative);
  if (const yaml::Node relaxation = keys["palm_relaxation"]) {
    const yaml::Map parts = relaxation.map({"share", "time_s"});
    gripper.palm_relaxation = parts["share"].number(yaml::between(0, kMaxRelaxation));
    gripper.palm_relaxation_s = parts["time_s"].number(yaml::between(kLeastRelaxation_s, 3600));
  }
  gripper.pad_friction = keys["pad_friction"].number_or(gripper.pad_friction, kNotNegative);
  return gripper;
}

std::vector<double> read_joints(const yaml::Node& node) {
  // Prismatic joints count in millimetres; the arm's own limits are checked with its model.
  std::vector<double> joints = node.numbers(1, 7, yaml::between(-5000, 5000));
  for (double& joint : joints) joint = radians(joint);
  return joints;
}

void read_types(const yaml::Map& keys, const FileScope& scope, Types& types) {
  for (const auto& [name, node] : keys["pockets"].entries()) {
    if (is_new(node, name, types.pockets)) types.pockets[name] = read_pocket(node);
  }
  for (const auto& [name, node] : keys["gear_types"].entries()) {
    if (is_new(node, name, types.gears)) types.gears[name] = read_gear_type(node, name);
  }
  for (const auto& [name, node] : keys["part_types"].entries()) {
    if (is_new(node, name, types.parts)) types.parts[name] = read_part_type(node, name);
  }
  for (const auto& [name, node] : keys["tray_types"].entries()) {
    if (is_new(node, name, types.trays)) types.trays[name] = read_tray_type(node, name, types);
  }
  for (const auto& [name, node] : keys["robot_types"].entries()) {
    if (is_new(node, name, types.robots)) types.robots[name] = read_robot_type(node, scope);
  }
}

}  // namespace aprsim::scene
