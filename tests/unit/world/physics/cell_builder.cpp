#include "tests/unit/world/physics/cell_builder.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace aprsim::physics::test {
namespace {

constexpr double kThickness = 0.015;
constexpr double kReach = 0.2;  // flange to tool tip

Eigen::Isometry3d tool_down(const Eigen::Vector3d& tip, double yaw) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  X.translation() = tip;
  return X;
}

}  // namespace

scene::TrayType tray_type(const std::string& gear, double half_size_m, double pitch_m) {
  scene::TrayType type;
  type.name = gear + "4";
  type.min_xy = {-half_size_m, -half_size_m};
  type.max_xy = {half_size_m, half_size_m};
  type.thickness_m = kThickness;
  type.mass_kg = 0.2;
  for (int i = 0; i < 4; ++i) {
    scene::Slot slot;
    slot.name = "s" + std::to_string(i + 1);
    slot.gear_type = gear;
    slot.xy = {i % 2 == 0 ? -pitch_m : pitch_m, i < 2 ? pitch_m : -pitch_m};
    slot.pocket = pocket_for(gear);
    type.slots.push_back(slot);
  }
  return type;
}

scene::Scene empty_scene() {
  scene::Scene scene;
  scene.name = "bench";
  scene.floor = false;
  for (const char* name : {"small", "medium", "large", "d50", "d60"}) {
    scene.gear_types[name] = gear_type(name);
  }
  scene.tray_types["small4"] = tray_type("small", 0.08, 0.045);
  scene.tray_types["medium4"] = tray_type("medium", 0.093, 0.05);
  scene.tray_types["d504"] = tray_type("d50", 0.08, 0.04);
  scene.tray_types["d604"] = tray_type("d60", 0.08, 0.04);
  return scene;
}

void add_table(scene::Scene& scene) {
  Pose pose;
  pose.p.z() = -0.025;
  scene.fixed.push_back({"table", {2, 2, 0.05}, pose});
}

void add_belt(scene::Scene& scene, double length_m) {
  scene::Conveyor conveyor;
  conveyor.length_m = length_m;
  conveyor.width_m = 0.6;
  conveyor.max_speed_m_s = 0.5;
  conveyor.max_accel_m_s2 = 0.5;
  scene.conveyor = conveyor;
}

void add_gear(scene::Scene& scene, const std::string& name, const std::string& type,
              const Pose& X_WP) {
  scene.gears.push_back({name, type, X_WP});
}

void add_tray(scene::Scene& scene, const std::string& name, const std::string& type,
              const Eigen::Vector2d& xy, const std::vector<std::string>& slots, double yaw_rad) {
  scene::TrayInstance tray;
  tray.name = name;
  tray.type = type;
  tray.X_WP.p = {xy.x(), xy.y(), scene.tray_types.at(type).thickness_m};
  tray.X_WP.q = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
  for (const auto& slot : scene.tray_types.at(type).slots) {
    for (const auto& wanted : slots) {
      if (wanted.substr(0, wanted.find('=')) != slot.name) continue;
      Pose pose = tray.X_WP;
      pose.p += tray.X_WP.q * Eigen::Vector3d(slot.xy.x(), slot.xy.y(), 0);
      const std::string gear = wanted.substr(wanted.find('=') + 1);
      tray.gears[slot.name] = gear;
      add_gear(scene, gear, slot.gear_type, pose);
    }
  }
  scene.trays.push_back(tray);
}

scene::Robot& add_hand(scene::Scene& scene, const Eigen::Vector3d& tip_W, double yaw_rad) {
  scene::Robot robot;
  robot.name = "hand" + std::to_string(scene.robots.size());
  robot.X_FT.p = {0, 0, kReach};
  auto& gripper = robot.gripper;
  gripper.stroke_m = 0.01;
  gripper.gap_open_m = 0.022;
  gripper.gap_closed_m = 0.002;
  gripper.force_n = 60;
  gripper.finger_speed_m_s = 0.15;
  gripper.pad_height_m = 0.03;
  gripper.pad_width_m = 0.014;
  gripper.pad_depth_m = 0.01;
  gripper.pad_friction = 0.7;
  gripper.v_half_angle_rad = 50 * std::numbers::pi / 180;
  gripper.v_depth_m = 3.85e-3;  // centres a peg from 2 mm off across the fingers
  gripper.finger_mass_kg = 0.1;
  gripper.palm_mass_kg = 0.4;
  gripper.palm_size = {0.06, 0.08, 0.08};
  robot.X_WB = Pose::from(tool_down(tip_W, yaw_rad) * robot.X_FT.isometry().inverse());
  scene.robots.push_back(robot);
  return scene.robots.back();
}

void add_busy_bodies(scene::Scene& scene) {
  add_tray(scene, "a", "small4", {0, 0}, {"s1=g1", "s2=g2", "s3=g3", "s4=g4"});
  add_tray(scene, "b", "small4", {0.3, 0}, {"s2=m2"});
  Pose loose;
  loose.p = {0.6, 0, 0.1};
  loose.q = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY());
  add_gear(scene, "loose", "medium", loose);
  add_hand(scene, {-0.0455, 0.0458, 0.0245 + 0.05}, 0.1);
}

Bench::Bench(scene::Scene the_scene) : scene(std::move(the_scene)) {
  std::vector<std::vector<Eigen::Isometry3d>> X_WL;
  for (const auto& robot : scene.robots) {
    robot::ArmModel model;
    model.name = robot.name;
    model.joints.resize(1);
    model.links.resize(2);
    models.push_back(model);
    X_WL.push_back({robot.X_WB.isometry(), robot.X_WB.isometry()});
  }
  if (!scene.robots.empty()) {
    X_WT = scene.robots[0].X_WB.isometry() * scene.robots[0].X_FT.isometry();
  }
  world = std::make_unique<PhysicsWorld>(scene, models, X_WL);
}

void Bench::run(int count) {
  for (int i = 0; i < count; ++i, ++steps) world->step();
}

void Bench::step_tool(const Eigen::Isometry3d& X_WT_next) {
  X_WT = X_WT_next;
  const Eigen::Isometry3d X_WF = X_WT * scene.robots[0].X_FT.isometry().inverse();
  const std::vector<Eigen::Isometry3d> links = {X_WF, X_WF};
  world->set_arm(0, links);
  run(1);
}

void Bench::move(const Eigen::Vector3d& delta, double seconds) {
  const Eigen::Isometry3d start = X_WT;
  const int count = static_cast<int>(std::lround(seconds / scene.physics.step_s));
  for (int i = 1; i <= count; ++i) {
    const double s = static_cast<double>(i) / count;
    Eigen::Isometry3d next = start;
    next.translation() += s * s * s * (10 - 15 * s + 6 * s * s) * delta;
    step_tool(next);
  }
}

void Bench::grip(double setting) {
  world->set_gripper(0, setting);
  for (int i = 0; i < 500 && !world->gripper(0).settled; ++i) run(1);
  run(50);
}

int Bench::index_of(const std::string& body) const {
  for (std::size_t i = 0; i < scene.trays.size(); ++i) {
    if (scene.trays[i].name == body) return static_cast<int>(i);
  }
  for (std::size_t i = 0; i < scene.gears.size(); ++i) {
    if (scene.gears[i].name == body) return static_cast<int>(scene.trays.size() + i);
  }
  for (std::size_t i = 0; i < scene.parts.size(); ++i) {
    if (scene.parts[i].name == body) {
      return static_cast<int>(scene.trays.size() + scene.gears.size() + i);
    }
  }
  throw std::invalid_argument("no body " + body);
}

Eigen::Isometry3d Bench::X_WB(const std::string& body) const {
  const BodyState state = world->body(index_of(body));
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = state.q_WB.toRotationMatrix();
  X.translation() = state.p_WB;
  return X;
}

Eigen::Isometry3d Bench::X_TB(const std::string& body) const {
  return world->gripper(0).X_WT.isometry().inverse() * X_WB(body);
}

double angle_between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Eigen::Quaterniond q(a.linear().transpose() * b.linear());
  return 2 * std::atan2(q.vec().norm(), std::abs(q.w()));
}

std::string name_of(const scene::Scene& scene, const PhysicsWorld& world,
                    const api::ContactSide& side) {
  const auto index = static_cast<std::size_t>(side.index);
  if (side.kind == api::ContactSide::Kind::kFixed) return world.fixed_names().at(index);
  if (side.kind == api::ContactSide::Kind::kRobot) return scene.robots.at(index).name;
  const std::size_t trays = scene.trays.size();
  const std::size_t gears = scene.gears.size();
  if (index < trays) return scene.trays[index].name;
  if (index < trays + gears) return scene.gears[index - trays].name;
  return scene.parts.at(index - trays - gears).name;
}

}  // namespace aprsim::physics::test
