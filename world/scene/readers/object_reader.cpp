#include "world/scene/readers/object_reader.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "world/scene/model/part_shapes.hpp"
#include "world/scene/model/pieces.hpp"
#include "world/scene/readers/camera_reader.hpp"
#include "world/scene/readers/crcl_joint_reader.hpp"
#include "world/scene/readers/device_reader.hpp"
#include "world/scene/readers/light_curtain_reader.hpp"
#include "world/scene/readers/modbus_reader.hpp"
#include "world/scene/readers/piece_reader.hpp"
#include "world/scene/readers/reading.hpp"
#include "world/scene/readers/server_reader.hpp"
#include "world/scene/readers/tool_reader.hpp"
#include "world/scene/readers/vision_reader.hpp"

namespace aprsim::scene {
namespace {

using yaml::kNotNegative;
using yaml::kPositive;

// An emergency stop brakes so much harder than an ordinary one, unless the scene says.
constexpr double kEmergencyFactor = 4;

constexpr std::size_t kMaxGripperNames = 8;

constexpr yaml::Range kMostResistanceMm = {.min = 0, .max = 10};
constexpr std::size_t kMaxTools = 16;
constexpr double kMaxGuardDelay_s = 1;
constexpr double kSeatTolerance = 1e-3;  // [m] of a tool over the bars of its holder
constexpr const char* kNoTool = "none";

constexpr const char* kConveyorName = "conveyor";
constexpr const char* kFloorName = "floor";

/// Values for some or all pairs of surfaces, `scale` times as large as in the file.
SurfacePairs read_pairs(const yaml::Node& node, SurfacePairs pairs, const yaml::Range& range,
                        double scale = 1) {
  if (!node) return pairs;
  const yaml::Map keys = node.map(
      {"gear_tray", "gear_gear", "gear_ground", "tray_belt", "tray_ground", "tray_tray", "robot"});
  const auto read = [&](const char* key, double& value) {
    value = scale * keys[key].number_or(value / scale, range);
  };
  read("gear_tray", pairs.gear_tray);
  read("gear_gear", pairs.gear_gear);
  read("gear_ground", pairs.gear_ground);
  read("tray_belt", pairs.tray_belt);
  read("tray_ground", pairs.tray_ground);
  read("tray_tray", pairs.tray_tray);
  read("robot", pairs.robot);
  return pairs;
}

/// Reads the objects of one scene, in the order in which they refer to each other.
class ObjectReader {
 public:
  ObjectReader(const Types& types, Scene& scene) : types_(types), scene_(scene) {}

  void robot(const yaml::Node& node) {
    const yaml::Map keys =
        node.map({"name", "type", "base", "crcl_frame", "crcl_tool_point", "crcl_joints",
                  "crcl_out_of_range", "gripper_names", "home_deg", "self_collision", "planning",
                  "clearance_m", "guard_delay_s", "force_sensor", "tool_changer", "tool", "vision",
                  "servers"});
    Robot robot;
    if (const Robot* type = read_reference(keys["type"], "robot type", types_.robots)) {
      robot = *type;
    }
    robot.name = claim(keys["name"], robots_, "robot");
    const yaml::Map base = keys["base"].map({"xyz_m", "rpy_deg"});
    robot.X_WB = read_pose(base["xyz_m"], base["rpy_deg"]);
    robot.X_BR = read_pose_map(keys["crcl_frame"]);
    robot.tool_point_F = read_tool_point(keys["crcl_tool_point"]);
    robot.crcl_joints = read_crcl_joints(keys["crcl_joints"], robot.home_rad.size());
    if (const yaml::Node rule = keys["crcl_out_of_range"]) {
      robot.clamps_targets = rule.word({"refuse", "clamp"}) == 1;
    }
    for (const yaml::Node& name : keys["gripper_names"].items()) {
      if (robot.gripper_names.size() == kMaxGripperNames) {
        name.unexpected("at most " + std::to_string(kMaxGripperNames) + " names");
      }
      robot.gripper_names.push_back(read_name(name));
    }
    if (const yaml::Node home = keys["home_deg"]) {
      const std::size_t joints = robot.home_rad.size();
      robot.home_rad = read_joints(home);
      if (robot.home_rad.size() != joints) {
        home.error("a list of " + std::to_string(robot.home_rad.size()),
                   std::to_string(joints) + " joints as in the robot type");
      }
    }
    robot.self_collision = keys["self_collision"].boolean_or(true);
    if (const yaml::Node mode = keys["planning"]) {
      robot.planning = static_cast<api::PlanningMode>(mode.word({"direct", "check", "avoid"}));
    }
    robot.clearance_m = keys["clearance_m"].number_or(robot.clearance_m, yaml::between(0, 0.2));
    robot.guard_delay_s = keys["guard_delay_s"].number_or(0, yaml::between(0, kMaxGuardDelay_s));
    robot.force_sensor = read_force_sensor(keys["force_sensor"]);
    robot.changer = read_tool_changer(keys["tool_changer"]);
    mount(keys["tool"], robot);
    robot.vision = read_vision(keys["vision"]);
    robot.simple_message = read_servers(keys["servers"], robot.home_rad.size());
    scene_.robots.push_back(std::move(robot));
  }

  void tool(const yaml::Node& node) {
    if (scene_.tools.size() == kMaxTools) {
      node.error("one tool more", "at most " + std::to_string(kMaxTools) + " tools");
    }
    const yaml::Map keys = node.map(kToolKeys);
    Tool tool = read_tool(keys);
    tool.name = claim(keys["name"], tool_names_, "tool");
    if (tool.name == kNoTool) keys["name"].unexpected("a name other than none");
    scene_.tools.push_back(std::move(tool));
    tool_nodes_.push_back(node);
  }

  void holder(const yaml::Node& node) {
    const yaml::Map keys = node.map(kHolderKeys);
    const std::string name = claim(keys["name"], holders_, "holder");
    Holder holder = read_holder(keys, name);
    for (StaticBox& bar : holder.bars) {
      if (!fixed_.insert(bar.name).second) {
        keys["name"].error("a bar " + bar.name + " with the name of a fixed object",
                           "unique names");
      }
      scene_.fixed.push_back(std::move(bar));
    }
    Tool* tool = take(keys["tool"]);
    if (tool == nullptr) return;
    tool->X_WQ = holder.X_WQ;
    if (std::abs(seat_of(*tool) - holder.seat_m) <= kSeatTolerance) return;
    keys["seat_m"].unexpected("the distance of " + tool->name + "'s palm from its coupling, " +
                              std::to_string(seat_of(*tool)) + ", within 1 mm");
  }

  /// After all robots and holders.
  void check_tools() const {
    for (std::size_t i = 0; i < scene_.tools.size(); ++i) {
      const std::string& name = scene_.tools[i].name;
      if (taken_.contains(name)) continue;
      tool_nodes_[i].error("tool " + name + " on no robot and in no holder",
                           "a robot or a holder with the key tool: " + name);
    }
  }

  void conveyor(const yaml::Node& node) {
    const yaml::Map keys =
        node.map({"xyz_m", "rpy_deg", "length_m", "width_m", "max_speed_m_s", "max_accel_m_s2",
                  "max_decel_m_s2", "emergency_decel_m_s2", "photo_eyes"});
    Conveyor conveyor;
    conveyor.X_WC = read_pose(keys["xyz_m"], keys["rpy_deg"]);
    conveyor.length_m = keys["length_m"].number(kLength);
    conveyor.width_m = keys["width_m"].number(kLength);
    conveyor.max_speed_m_s = keys["max_speed_m_s"].number(kPositive);
    conveyor.max_accel_m_s2 = keys["max_accel_m_s2"].number(kPositive);
    conveyor.max_decel_m_s2 = keys["max_decel_m_s2"].number_or(conveyor.max_accel_m_s2, kPositive);
    conveyor.emergency_decel_m_s2 = keys["emergency_decel_m_s2"].number_or(
        kEmergencyFactor * conveyor.max_decel_m_s2, yaml::at_least(conveyor.max_decel_m_s2));
    for (const yaml::Node& eye : keys["photo_eyes"].items()) {
      if (conveyor.photo_eyes.size() == api::kMaxPhotoEyes) {
        eye.unexpected("at most " + std::to_string(api::kMaxPhotoEyes) + " photo-eyes");
      }
      conveyor.photo_eyes.push_back(photo_eye(eye, conveyor.length_m));
    }
    scene_.conveyor = conveyor;
    supports_[kConveyorName] = {conveyor.X_WC, {conveyor.length_m / 2, conveyor.width_m / 2}};
  }

  PhotoEye photo_eye(const yaml::Node& node, double belt_length_m) {
    const yaml::Map keys = node.map({"name", "x_m", "height_m"});
    PhotoEye eye;
    eye.name = claim(keys["name"], photo_eyes_, "photo-eye");
    eye.x_m = keys["x_m"].number(yaml::between(-belt_length_m / 2, belt_length_m / 2));
    eye.height_m = keys["height_m"].number(kLength);
    return eye;
  }

  void fixed(const yaml::Node& node) {
    const yaml::Map keys = node.map({"name", "size_m", "xyz_m", "rpy_deg"});
    StaticBox box;
    box.name = claim(keys["name"], fixed_, "fixed object");
    if (box.name == kConveyorName || box.name == kFloorName) {
      keys["name"].unexpected("a name other than conveyor and floor");
    }
    box.size = read_xyz(keys["size_m"], kLength);
    box.X_WS = read_pose(keys["xyz_m"], keys["rpy_deg"]);
    Pose top = box.X_WS;
    top.p += top.q * Eigen::Vector3d(0, 0, box.size.z() / 2);
    supports_[box.name] = {top, {box.size.x() / 2, box.size.y() / 2}};
    scene_.fixed.push_back(std::move(box));
  }

  void fixture(const yaml::Node& node) {
    const yaml::Map keys = node.map({"name", "pieces", "material", "xyz_m", "rpy_deg"});
    Fixture fixture = read_fixture(keys);
    fixture.name = claim(keys["name"], fixed_, "fixed object");
    if (fixture.name == kConveyorName || fixture.name == kFloorName) {
      keys["name"].unexpected("a name other than conveyor and floor");
    }
    scene_.fixtures.push_back(std::move(fixture));
  }

  void part(const yaml::Node& node) {
    const yaml::Map keys = node.map({"name", "type", "on", "xy_m", "yaw_deg", "xyz_m", "rpy_deg"});
    PartInstance part;
    part.name = claim(keys["name"], bodies_, "body");
    const PartType* type = read_reference(keys["type"], "part type", types_.parts);
    if (!type) return;
    part.type = type->name;
    const Eigen::AlignedBox3d box = bounds_of(type->pieces);
    part.X_WP = keys["on"] ? pose_on_support(keys, {"part", -box.min().z(), box.center().head<2>()})
                           : free_pose(keys);
    scene_.parts.push_back(std::move(part));
    nodes_.parts.push_back(node);
  }

  void tray(const yaml::Node& node) {
    const yaml::Map keys = node.map(
        {"name", "type", "on", "xy_m", "yaw_deg", "xyz_m", "rpy_deg", "gears", "reachable_by"});
    TrayInstance tray;
    tray.name = claim(keys["name"], bodies_, "body");
    const TrayType* type = read_reference(keys["type"], "tray type", types_.trays);
    if (!type) return;
    tray.type = type->name;
    tray.X_WP =
        keys["on"]
            ? pose_on_support(keys, {"tray", type->thickness_m, (type->min_xy + type->max_xy) / 2})
            : free_pose(keys);
    for (const auto& [slot_name, gear] : keys["gears"].entries()) {
      seat_gear(slot_name, gear, *type, tray);
    }
    for (const yaml::Node& item : keys["reachable_by"].items()) {
      const std::string name = item.text();
      if (!robots_.contains(name)) {
        report_unknown(item, name, "robot", {robots_.begin(), robots_.end()});
      }
      tray.reachable_by.push_back(name);
    }
    scene_.trays.push_back(std::move(tray));
    nodes_.trays.push_back(node);
  }

  void loose_gear(const yaml::Node& node) {
    const yaml::Map keys = node.map({"name", "type", "xyz_m", "rpy_deg"});
    GearInstance gear;
    gear.name = claim(keys["name"], bodies_, "body");
    const GearType* type = read_reference(keys["type"], "gear type", types_.gears);
    if (!type) return;
    gear.type = type->name;
    gear.X_WP = read_pose(keys["xyz_m"], keys["rpy_deg"]);
    scene_.gears.push_back(std::move(gear));
    nodes_.gears.push_back(node);
  }

  void enable_floor() { supports_[kFloorName] = {Pose{}, {1e3, 1e3}}; }

  [[nodiscard]] const BodyNodes& nodes() const { return nodes_; }

 private:
  /// A face that a tray can be put on: its pose and half its size.
  struct Support {
    Pose X_WF;
    Eigen::Vector2d half_size;
  };

  static std::string claim(const yaml::Node& node, std::set<std::string>& claimed,
                           const std::string& what) {
    std::string name = read_name(node);
    if (!claimed.insert(name).second) {
      node.error("a second " + what + ' ' + name, "unique names");
    }
    return name;
  }

  /// The tool that a robot or a holder names; null for none, and after an error.
  Tool* take(const yaml::Node& node) {
    if (!node || node.text() == kNoTool) return nullptr;
    const std::string name = node.text();
    if (!tool_names_.contains(name)) {
      report_unknown(node, name, "tool", {tool_names_.begin(), tool_names_.end()});
      return nullptr;
    }
    if (!taken_.insert(name).second) {
      node.error("tool " + name + " in a second place", "each tool on one robot or in one holder");
    }
    return &*std::find_if(scene_.tools.begin(), scene_.tools.end(),
                          [&](const Tool& tool) { return tool.name == name; });
  }

  /// A robot with a listed tool, or none, has that in place of its type's gripper.
  void mount(const yaml::Node& node, Robot& robot) {
    if (!node) return;
    const Tool* tool = take(node);
    robot.tool = tool == nullptr ? "" : tool->name;
    if (tool == nullptr) return;
    const Pose X_FQ = coupling_of(robot);
    robot.changer.X_FQ = X_FQ;
    robot.X_FT = Pose::from(X_FQ.isometry() * tool->X_QT.isometry());
    robot.gripper = tool->gripper;
  }

  static Pose free_pose(const yaml::Map& keys) {
    for (const char* key : {"xy_m", "yaw_deg"}) {
      if (const yaml::Node node = keys[key]) {
        node.error("a place on a support",
                   "the key \"on\" beside it, or xyz_m and rpy_deg instead");
      }
    }
    return read_pose(keys["xyz_m"], keys["rpy_deg"]);
  }

  /// Something that can be put on a support.
  struct Footprint {
    std::string kind;
    double below_m;          // from its frame down to its underside
    Eigen::Vector2d middle;  // of its underside, in its frame
  };

  Pose pose_on_support(const yaml::Map& keys, const Footprint& thing) const {
    for (const char* key : {"xyz_m", "rpy_deg"}) {
      if (const yaml::Node node = keys[key]) {
        node.error("a place in the world", "xy_m and yaw_deg, as \"on\" is given");
      }
    }
    Pose pose;
    pose.p.head<2>() = read_xy(keys["xy_m"]);
    const double yaw = radians(keys["yaw_deg"].number_or(0, yaml::between(-360, 360)));
    pose.q = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
    const Support* support = read_reference(keys["on"], "support", supports_);
    if (!support) return pose;
    if ((support->X_WF.q * Eigen::Vector3d::UnitZ()).z() < 1 - 1e-9) {
      keys["on"].unexpected("a support with a horizontal top face");
    }
    pose.p.z() = support->X_WF.p.z() + thing.below_m;
    const Eigen::Vector3d centre =
        pose.p + pose.q * Eigen::Vector3d(thing.middle.x(), thing.middle.y(), 0);
    const Eigen::Vector3d p_F = support->X_WF.q.inverse() * (centre - support->X_WF.p);
    if ((p_F.head<2>().cwiseAbs().array() > support->half_size.array()).any()) {
      keys["xy_m"].error("a " + thing.kind + " whose middle is beside " + keys["on"].text(),
                         "it above");
    }
    return pose;
  }

  void seat_gear(const std::string& slot_name, const yaml::Node& node, const TrayType& type,
                 TrayInstance& tray) {
    const auto slot = std::find_if(type.slots.begin(), type.slots.end(),
                                   [&](const Slot& s) { return s.name == slot_name; });
    if (slot == type.slots.end()) {
      std::vector<std::string> names;
      for (const Slot& s : type.slots) names.push_back(s.name);
      report_unknown(node, slot_name, "slot", names);
      return;
    }
    GearInstance gear;
    gear.type = slot->gear_type;
    gear.X_WP.p = tray.X_WP.p + tray.X_WP.q * Eigen::Vector3d(slot->xy.x(), slot->xy.y(), 0);
    gear.X_WP.q = tray.X_WP.q;
    double yaw = slot->yaw_rad;
    if (node.is_map()) {
      const yaml::Map keys = node.map({"name", "yaw_deg"});
      gear.name = claim(keys["name"], bodies_, "body");
      yaw += radians(keys["yaw_deg"].number_or(0, yaml::between(-360, 360)));
    } else {
      gear.name = claim(node, bodies_, "body");
    }
    if (node.is_map() || yaw != 0) {
      gear.X_WP.q = tray.X_WP.q * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
    }
    tray.gears[slot_name] = gear.name;
    if (types_.parts.contains(gear.type)) {
      scene_.parts.push_back({gear.name, gear.type, gear.X_WP});
      nodes_.parts.push_back(node);
      return;
    }
    scene_.gears.push_back(std::move(gear));
    nodes_.gears.push_back(node);
  }

  const Types& types_;
  Scene& scene_;
  BodyNodes nodes_;
  std::set<std::string> robots_, fixed_, bodies_, photo_eyes_, tool_names_, holders_;
  std::set<std::string> taken_;  // tools with a place
  std::vector<yaml::Node> tool_nodes_;
  std::map<std::string, Support> supports_;
};

OdeSettings read_ode_settings(const yaml::Node& node) {
  constexpr std::int64_t kMostIterations = 10000;
  OdeSettings ode;
  const yaml::Map keys = node.map({"stepper", "iterations", "erp", "cfm"});
  ode.stepper = static_cast<OdeSettings::Stepper>(keys["stepper"].word_or(0, {"quick", "direct"}));
  ode.iterations =
      static_cast<int>(keys["iterations"].integer_or(ode.iterations, 1, kMostIterations));
  ode.erp = keys["erp"].number_or(ode.erp, {.min = 0, .max = 1, .open_min = true});
  ode.cfm_m_s_n = keys["cfm"].number_or(ode.cfm_m_s_n, {.min = 1e-10, .max = 1e-2});
  return ode;
}

}  // namespace

Physics read_physics(const yaml::Node& node) {
  Physics physics;
  if (!node) return physics;
  const yaml::Map keys = node.map(kPhysicsKeys);
  // The explicit springs of the contact and gripper laws are stable up to 2 ms.
  physics.step_s =
      keys["step_s"].number_or(physics.step_s, {.min = 0, .max = 0.002, .open_min = true});
  physics.gravity_m_s2 = keys["gravity_m_s2"].number_or(physics.gravity_m_s2, kNotNegative);
  physics.friction = read_pairs(keys["friction"], physics.friction, kNotNegative);
  physics.restitution = read_pairs(keys["restitution"], physics.restitution, {.min = 0, .max = 1});
  physics.rolling_m =
      read_pairs(keys["rolling_resistance_mm"], physics.rolling_m, kMostResistanceMm, 1e-3);
  physics.spinning_m =
      read_pairs(keys["spinning_resistance_mm"], physics.spinning_m, kMostResistanceMm, 1e-3);
  physics.materials = read_material_pairs(keys["materials"]);
  physics.residual_m_s =
      keys["residual_m_s"].number_or(physics.residual_m_s, {.min = 1e-8, .max = 1e-3});
  physics.simplification = static_cast<Simplification>(
      keys["simplification"].word_or(static_cast<std::size_t>(physics.simplification),
                                     {"off", "virtual_joints", "merge", "dormant"}));
  physics.simplify_speed_m_s =
      keys["simplify_speed_m_s"].number_or(physics.simplify_speed_m_s, kPositive);
  physics.simplify_accel_m_s2 =
      keys["simplify_accel_m_s2"].number_or(physics.simplify_accel_m_s2, kPositive);
  physics.simplify_force_n =
      keys["simplify_force_n"].number_or(physics.simplify_force_n, kPositive);
  physics.engine = static_cast<PhysicsEngine>(keys["engine"].word_or(0, {"aprsim", "ode"}));
  if (const yaml::Node ode = keys["ode"]) {
    if (physics.engine != PhysicsEngine::kOde) {
      ode.error("settings of ODE with the engine aprsim", "engine: ode with them");
    }
    physics.ode = read_ode_settings(ode);
  }
  return physics;
}

BodyNodes read_objects(const yaml::Map& keys, const Types& types, Scene& scene) {
  ObjectReader reader(types, scene);
  scene.floor = keys["floor"].boolean_or(true);
  if (scene.floor) reader.enable_floor();
  for (const yaml::Node& node : keys["tools"].items()) reader.tool(node);
  for (const yaml::Node& node : keys["robots"].items()) reader.robot(node);
  read_cameras(keys["cameras"], scene);
  if (const yaml::Node node = keys["conveyor"]) reader.conveyor(node);
  for (const yaml::Node& node : keys["fixed"].items()) reader.fixed(node);
  for (const yaml::Node& node : keys["fixtures"].items()) reader.fixture(node);
  for (const yaml::Node& node : keys["holders"].items()) reader.holder(node);
  reader.check_tools();
  read_light_curtain(keys["light_curtain"], scene);
  for (const yaml::Node& node : keys["trays"].items()) reader.tray(node);
  for (const yaml::Node& node : keys["gears"].items()) reader.loose_gear(node);
  for (const yaml::Node& node : keys["parts"].items()) reader.part(node);
  read_devices(keys["devices"], scene);
  read_modbus_servers(keys["modbus_servers"], scene);
  return reader.nodes();
}

}  // namespace aprsim::scene
