#include "tests/benchmarks/turning/held_part.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::bench {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kHeight = 1;                          // of the gripped gear's tool tip [m]
constexpr double kGearBelowTip = 0.0095;               // origin of a gear gripped by its peg [m]
constexpr double kDepth = 0.025, kCupOverPart = 5e-4;  // [m]
constexpr double kLift = 0.5;  // so high that nothing turns into the stand [m]

/// A box whose top face is at a height.
void add_stand(scene::Scene& scene, double top_m, double width_m) {
  constexpr double kThickness = 0.05;
  Pose pose;
  pose.p.z() = top_m - 0.5 * kThickness;
  scene.fixed.push_back({"stand", {width_m, width_m, kThickness}, pose});
}

void add_gear_in_fingers(scene::Scene& scene, scene::PadShape pad) {
  physics::test::add_hand(scene, {0, 0, kHeight}).gripper.pad = pad;
  Pose gear;
  gear.p.z() = kHeight - kGearBelowTip;
  physics::test::add_gear(scene, "part", "medium", gear);
  add_stand(scene, gear.p.z() - scene.gear_types.at("medium").hub_height_m, 0.2);
}

/// A tray over the edges of its stand, and a level hand on one of its edges.
void add_tray_in_fingers(scene::Scene& scene) {
  physics::test::add_tray(scene, "part", "small4", {0, 0}, {});
  add_stand(scene, 0, 0.1);
  scene::Robot& robot = physics::test::add_hand(scene, Vector3d::Zero());
  robot.gripper.pad = scene::PadShape::kFlat;
  const scene::TrayType& type = scene.tray_types.at("small4");
  Isometry3d X_WT = Isometry3d::Identity();
  X_WT.linear().col(2) = Vector3d::UnitX();
  X_WT.linear().col(1) = Vector3d::UnitZ();
  X_WT.linear().col(0) = Vector3d::UnitZ().cross(Vector3d::UnitX());
  X_WT.translation() = Vector3d(type.min_xy.x() + kDepth, 0, 0.5 * type.thickness_m);
  robot.X_WB = Pose::from(X_WT * robot.X_FT.isometry().inverse());
}

void add_disc_under_cup(scene::Scene& scene) {
  scene::GearType disc;
  disc.name = "disc";
  disc.disc_radius_m = 0.03;
  disc.disc_height_m = disc.peg_top_m = 0.01;
  disc.mass_kg = 0.05;
  scene.gear_types["disc"] = disc;
  physics::test::add_gear(scene, "part", "disc", {});
  add_stand(scene, 0, 0.2);
  const Vector3d tip(0, 0, disc.disc_height_m + kCupOverPart);
  physics::test::add_hand(scene, tip).gripper.cup = scene::VacuumCup{.radius_m = 0.012,
                                                                     .max_vacuum_pa = 60e3,
                                                                     .free_flow_m3_s = 1e-3,
                                                                     .evacuation_s = 0.03,
                                                                     .lip_compliance_m = 2e-3,
                                                                     .roughness_m = 5e-6};
}

scene::Scene scene_of(const HeldPart::Setting& setting) {
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.simplification = setting.mode;
  scene.physics.step_s = setting.step_s;
  scene.physics.gravity_m_s2 = setting.gravity_m_s2;
  switch (setting.grasp) {
    case Grasp::kFlatPads:
      add_gear_in_fingers(scene, scene::PadShape::kFlat);
      break;
    case Grasp::kVPads:
      add_gear_in_fingers(scene, scene::PadShape::kV);
      break;
    case Grasp::kTrayByEdge:
      add_tray_in_fingers(scene);
      break;
    case Grasp::kCup:
      add_disc_under_cup(scene);
      break;
  }
  return scene;
}

/// From 0 to 1, at rest at both ends.
double quintic(double share) { return share * share * share * (10 + share * (6 * share - 15)); }

/// Greatest rate and acceleration of that profile over unit time.
constexpr double kQuinticRate = 1.875;
constexpr double kWhole = 4e-3;  // [s]
const double kQuinticAccel = 10 / std::sqrt(3.0);

}  // namespace

const char* name_of(Grasp grasp) {
  switch (grasp) {
    case Grasp::kFlatPads:
      return "flat_pads";
    case Grasp::kVPads:
      return "v_pads";
    case Grasp::kTrayByEdge:
      return "tray";
    case Grasp::kCup:
      return "cup";
  }
  return "";
}

double Turn::seconds() const {
  const double least = std::max(kQuinticRate * angle_rad / max_rad_s,
                                std::sqrt(kQuinticAccel * angle_rad / max_rad_s2));
  return kWhole * std::ceil(least / kWhole);
}

Turn random_turn(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::normal_distribution<double> normal;
  const auto direction = [&] {
    const double x = normal(engine), y = normal(engine);
    return Vector3d(x, y, normal(engine)).normalized();
  };
  Turn turn;
  turn.axis_T = direction();
  turn.point_T = 0.1 * std::cbrt(unit(engine)) * direction();
  turn.angle_rad = 0.2 + 1.8 * unit(engine);
  turn.max_rad_s = 2 + 4 * unit(engine);
  turn.max_rad_s2 = 20 + 40 * unit(engine);
  return turn;
}

HeldPart::HeldPart(const Setting& setting) : bench_(scene_of(setting)) {
  rest(0.05);
  if (setting.grasp == Grasp::kCup) bench_.move({0, 0, -1.6 * kCupOverPart}, 0.1);
  bench_.world->set_gripper(0, 0);
  rest(0.5);
  bench_.move({0, 0, kLift}, 1);
  rest(0.3);
}

void HeldPart::turn(const Turn& turn, double sign, double share) {
  const Isometry3d start = bench_.X_WT;
  const auto steps = static_cast<int>(std::lround(turn.seconds() / bench_.scene.physics.step_s));
  for (int i = 1; i <= share * steps; ++i) {
    const double angle = sign * turn.angle_rad * quintic(double(i) / steps);
    bench_.step_tool(start * Eigen::Translation3d(turn.point_T) *
                     Eigen::AngleAxisd(angle, turn.axis_T) * Eigen::Translation3d(-turn.point_T));
  }
}

void HeldPart::swing(const Turn& one) {
  const Isometry3d start = bench_.X_WT;
  turn(one);
  turn(one, -1);
  bench_.X_WT = start;  // without the rounding of the way
}

void HeldPart::rest(double seconds) {
  bench_.run(static_cast<int>(std::lround(seconds / bench_.scene.physics.step_s)));
}

}  // namespace aprsim::bench
