#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"
#include "tests/unit/world/physics/random_impact.hpp"
#include "tests/unit/world/physics/random_part.hpp"
#include "world/scene/model/pieces.hpp"

// Parts of any shape in the whole physics, against closed forms.
namespace aprsim::physics::test {
namespace {

using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kGravity = 9.81;

api::Piece cylinder(double radius_m, double height_m) {
  return {api::ConePiece{radius_m, radius_m, height_m}, {}};
}
api::Piece box(double x, double y, double z) { return {api::BoxPiece{{x, y, z}}, {}}; }
api::Piece ball(double radius_m) { return {api::CapsulePiece{radius_m, 0}, {}}; }

api::Piece at(api::Piece piece, double x, double y, double z,
              const Quaterniond& q = Quaterniond::Identity()) {
  piece.X_BP.p = {x, y, z};
  piece.X_BP.q = q;
  return piece;
}

Quaterniond turned(double angle, const Vector3d& axis) {
  return Quaterniond(Eigen::AngleAxisd(angle, axis));
}

/// One part of each kind of piece, which stands on a face or lies on its side.
struct Standing {
  const char* name;
  scene::PartType type;
  Quaterniond q = Quaterniond::Identity();  ///< in which it stands
};

std::vector<Standing> standing_parts() {
  const Quaterniond lying = turned(std::numbers::pi / 2, Vector3d::UnitY());
  std::vector<Standing> parts;
  parts.push_back({"box", part_type("box", {box(0.03, 0.04, 0.02)}, 0.2)});
  parts.push_back({"cylinder", part_type("cylinder", {cylinder(0.015, 0.03)}, 0.2)});
  parts.push_back({"lying cylinder", part_type("cylinder", {cylinder(0.015, 0.04)}, 0.2), lying});
  parts.push_back({"cone", part_type("cone", {{api::ConePiece{0.02, 0.005, 0.03}, {}}}, 0.2)});
  parts.push_back(
      {"prism", part_type("prism", {{api::PrismPiece{regular_polygon(6, 0.02), 0.02}, {}}}, 0.2)});
  parts.push_back({"hull", part_type("hull",
                                     {{scene::hull_of(std::vector<Vector3d>{{-0.02, -0.02, 0},
                                                                            {0.02, -0.02, 0},
                                                                            {0.02, 0.02, 0},
                                                                            {-0.02, 0.02, 0},
                                                                            {0, 0, 0.03}}),
                                       {}}},
                                     0.2)});
  parts.push_back(
      {"capsule", part_type("capsule", {{api::CapsulePiece{0.01, 0.04}, {}}}, 0.2), lying});
  parts.push_back(
      {"union", part_type("union",
                          {box(0.05, 0.03, 0.02), at(cylinder(0.008, 0.01), 0.01, 0, 0.015),
                           at(box(0.02, 0.03, 0.02), 0.015, 0, -0.02),
                           at(box(0.02, 0.03, 0.02), -0.015, 0, -0.02)},
                          0.3)});
  return parts;
}

/// Height of the part's frame over a plane that it stands on.
double standing_height(const Standing& part) {
  double lowest = 1e30;
  for (const api::Piece& piece : part.type.pieces) {
    const Eigen::Matrix3d R = (part.q * piece.X_BP.q).toRotationMatrix();
    const Vector3d down = R.transpose() * -Vector3d::UnitZ();
    const Vector3d p = part.q * (piece.X_BP.q * scene::support_of(piece, down) + piece.X_BP.p);
    lowest = std::min(lowest, p.z());
  }
  return -lowest;
}

class PartModes : public testing::TestWithParam<scene::Simplification> {};
INSTANTIATE_TEST_SUITE_P(Modes, PartModes,
                         testing::Values(scene::Simplification::kOff,
                                         scene::Simplification::kVirtualJoints,
                                         scene::Simplification::kMerge,
                                         scene::Simplification::kDormant));

TEST_P(PartModes, RestWithoutDrift) {
  for (const Standing& part : standing_parts()) {
    for (const double yaw : {0.0, 0.7}) {
      auto scene = empty_scene();
      scene.physics.simplification = GetParam();
      add_table(scene);
      // Without it what is round rolls on for ever.
      scene.physics.rolling_m.gear_ground = 5e-5;
      Pose pose;
      pose.q = turned(yaw, Vector3d::UnitZ()) * part.q;
      pose.p.z() = standing_height(part) + 1e-3;
      add_part(scene, "part", part.type, pose);
      Bench bench(std::move(scene));
      bench.run(700);
      const Isometry3d settled = bench.X_WB("part");
      EXPECT_NEAR(settled.translation().z(), standing_height(part), 12e-6) << part.name << yaw;
      EXPECT_TRUE(bench.world->body(0).resting) << part.name << yaw;
      bench.run(2000);
      EXPECT_LT((bench.X_WB("part").translation() - settled.translation()).norm(), 2e-7)
          << part.name << yaw;
      EXPECT_LT(angle_between(bench.X_WB("part"), settled), 1e-5) << part.name << yaw;
      EXPECT_LT(bench.world->body(0).v_W.norm(), 1e-7) << part.name << yaw;
      EXPECT_EQ(bench.world->penetration_faults(), 0u);
    }
  }
}

/// A ramp: a thick plate, or the same as a hull. Its top passes through the origin.
struct Ramp {
  double angle, heading;
  [[nodiscard]] Quaterniond q() const {
    return turned(heading, Vector3d::UnitZ()) * turned(angle, Vector3d::UnitY());
  }
  /// Down the ramp.
  [[nodiscard]] Vector3d down() const { return q() * Vector3d::UnitX(); }
  [[nodiscard]] Vector3d normal() const { return q() * Vector3d::UnitZ(); }
  void add_to(scene::Scene& scene, bool as_hull) const {
    constexpr double kHalf = 4, kThick = 0.2;
    Pose pose;
    pose.q = q();
    if (!as_hull) {
      pose.p = -0.5 * kThick * normal();
      scene.fixed.push_back({"ramp", {2 * kHalf, 2 * kHalf, kThick}, pose});
      return;
    }
    std::vector<Vector3d> corners;
    for (const double x : {-kHalf, kHalf}) {
      for (const double y : {-kHalf, kHalf}) {
        for (const double z : {-kThick, 0.0}) corners.emplace_back(x, y, z);
      }
    }
    add_fixture(scene, "ramp", {{scene::hull_of(corners), {}}}, pose);
  }
};

/// The part on a ramp, turned by `yaw` about its normal.
Bench on_ramp(const Standing& part, const Ramp& ramp, double mu, double yaw, bool as_hull) {
  auto scene = empty_scene();
  scene.physics.simplification = scene::Simplification::kOff;
  scene.physics.friction.gear_ground = mu;
  ramp.add_to(scene, as_hull);
  Pose pose;
  pose.q = ramp.q() * turned(yaw, Vector3d::UnitZ()) * part.q;
  pose.p = standing_height(part) * ramp.normal();
  add_part(scene, "part", part.type, pose);
  return Bench(std::move(scene));
}

// Coulomb: g (sin - mu cos) down a ramp, whatever the kind and wherever it points.
TEST(Parts, SlideAsCoulombSays) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> turn(-3, 3);
  for (const Standing& part : standing_parts()) {
    for (const bool as_hull : {false, true}) {
      const Ramp ramp{0.35, turn(random)};
      const double mu = 0.2, seconds = 0.5;
      const bool round = part.q.w() < 0.9;  // lying: its axis is across the ramp's fall line
      Bench bench = on_ramp(part, ramp, mu, round ? 0 : turn(random), as_hull);
      const Vector3d start = bench.X_WB("part").translation();
      bench.run(500);
      const Vector3d way = bench.X_WB("part").translation() - start;
      const double expected =
          0.5 * kGravity * (std::sin(0.35) - mu * std::cos(0.35)) * seconds * seconds;
      EXPECT_NEAR(way.dot(ramp.down()), expected, 0.01 * expected) << part.name << as_hull;
    }
  }
}

// A ball rolls with 5/7 and a cylinder with 2/3 of g sin.
TEST(Parts, RollAsTheirInertiaSays) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> turn(-3, 3);
  const Quaterniond across = turned(std::numbers::pi / 2, Vector3d::UnitX());
  const std::vector<std::pair<Standing, double>> rolling = {
      {{"ball", part_type("ball", {ball(0.02)}, 0.2)}, 5.0 / 7},
      {{"cylinder", part_type("cylinder", {cylinder(0.02, 0.03)}, 0.2), across}, 2.0 / 3}};
  for (const auto& [part, share] : rolling) {
    for (const bool as_hull : {false, true}) {
      for (int i = 0; i < 3; ++i) {
        const Ramp ramp{0.2, turn(random)};
        Bench bench = on_ramp(part, ramp, 0.6, 0, as_hull);
        const Vector3d start = bench.X_WB("part").translation();
        bench.run(800);
        const Vector3d way = bench.X_WB("part").translation() - start;
        const double expected = 0.5 * share * kGravity * std::sin(0.2) * 0.8 * 0.8;
        EXPECT_NEAR(way.dot(ramp.down()), expected, 0.01 * expected) << part.name << as_hull;
        EXPECT_LT((way - way.dot(ramp.down()) * ramp.down()).norm(), 0.01 * expected)
            << part.name << as_hull;
      }
    }
  }
}

// It tips over where its centre of mass is beyond its lower edge: within 1 % of that angle it
// stands on one side of it and falls on the other.
TEST(Parts, TipWhereTheirCentreOfMassSays) {
  struct Tall {
    Standing part;
    double half_width_m, com_height_m, yaw;
  };
  const auto hexagon = regular_polygon(6, 0.012);
  const std::vector<Tall> parts = {
      {{"box", part_type("box", {box(0.02, 0.03, 0.06)}, 0.2)}, 0.01, 0.03, 0},
      {{"cylinder", part_type("cylinder", {cylinder(0.012, 0.06)}, 0.2)}, 0.012, 0.03, 0},
      {{"cylinder 30", part_type("cylinder", {cylinder(0.012, 0.06)}, 0.2)}, 0.012, 0.03, 0.5236},
      {{"prism", part_type("prism", {{api::PrismPiece{hexagon, 0.06}, {}}}, 0.2)},
       0.012 * std::cos(std::numbers::pi / 6),
       0.03,
       std::numbers::pi / 6}};
  for (const Tall& tall : parts) {
    const double angle = std::atan2(tall.half_width_m, tall.com_height_m);
    for (const double heading : {0.0, 1.1, -2.4}) {
      for (const double share : {0.99, 1.01}) {
        Bench bench = on_ramp(tall.part, Ramp{share * angle, heading}, 1.5, tall.yaw, heading != 0);
        const Isometry3d start = bench.X_WB("part");
        bench.run(1500);
        const double turned_by = angle_between(bench.X_WB("part"), start);
        if (share < 1) {
          EXPECT_LT(turned_by, 0.02) << tall.part.name << heading;
        } else {
          EXPECT_GT(turned_by, 0.5) << tall.part.name << heading;
        }
      }
    }
  }
}

// A falling box turns about its edge: its energy gives its speed.
TEST(Parts, ToppleAsEnergySays) {
  auto scene = empty_scene();
  scene.physics.simplification = scene::Simplification::kOff;
  scene.physics.friction.gear_ground = 3;
  add_table(scene);
  const double wide = 0.02, high = 0.06, L = 0.5 * std::hypot(wide, high);
  const double balanced = std::atan2(wide, high), begin = balanced + 0.05;
  const scene::PartType type = part_type("box", {box(wide, 0.03, high)}, 0.2);
  Pose pose;
  pose.q = turned(begin, Vector3d::UnitY());
  // Its lower edge at x = wide / 2 is on the table.
  pose.p.z() = L * std::cos(begin - balanced);
  add_part(scene, "part", type, pose);
  Bench bench(std::move(scene));
  const double inertia = type.inertia(1, 1) + type.mass_kg * L * L;
  double from_upright = 0;
  for (int i = 0; i < 2000 && from_upright < 0.9; ++i) {
    bench.run(1);
    const Isometry3d X = bench.X_WB("part");
    from_upright = std::atan2(X.linear()(0, 2), X.linear()(2, 2)) - balanced;
  }
  ASSERT_GE(from_upright, 0.9);
  const double energy =
      type.mass_kg * kGravity * L * (std::cos(begin - balanced) - std::cos(from_upright));
  EXPECT_NEAR(bench.world->body(0).omega_W.norm(), std::sqrt(2 * energy / inertia),
              0.01 * std::sqrt(2 * energy / inertia));
}

TEST(Parts, ImpactsMakeNoEnergyAndKeepMomenta) {
  int touched = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const ImpactOutcome impact = random_impact(seed, {.parts = true});
    EXPECT_LT(impact.energy_ratio, 1 + 1e-9) << "seed " << seed;
    EXPECT_LT(impact.momentum_error, 1e-12) << "seed " << seed;
    EXPECT_LT(impact.angular_momentum_error, 1e-9) << "seed " << seed;
    touched += impact.touched;
  }
  EXPECT_GT(touched, 200);
}

// Parts of every kind at 10 m/s at a plate of 5 mm, as a box and as a hull.
TEST(Parts, NothingPassesAThinPlate) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> share(-1, 1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 84; ++i) {
    auto scene = empty_scene();
    const api::Piece piece = random_piece(static_cast<PieceShape>(i % kPieceShapes), 0.03, random);
    if (i % 2 == 0) {
      Pose plate;
      plate.p.z() = -0.0025;
      scene.fixed.push_back({"plate", {20, 20, 0.005}, plate});
    } else {
      std::vector<Vector3d> corners;
      for (const double x : {-10.0, 10.0}) {
        for (const double y : {-10.0, 10.0}) {
          for (const double z : {-0.005, 0.0}) corners.emplace_back(x, y, z);
        }
      }
      add_fixture(scene, "plate", {{scene::hull_of(corners), {}}});
    }
    Pose above;
    above.p.z() = 0.3;
    const double w = normal(random), x = normal(random), y = normal(random);
    above.q = Quaterniond(w, x, y, normal(random)).normalized();
    add_part(scene, "part", part_type("any", {piece}, 0.2), above);
    Bench bench(std::move(scene));
    bench.world->set_velocity(0, {3 * share(random), 0, -10},
                              5 * Vector3d(share(random), share(random), share(random)));
    for (int step = 0; step < 300; ++step) {
      bench.run(1);
      const Isometry3d X = bench.X_WB("part");
      const Vector3d down = X.linear().transpose() * -Vector3d::UnitZ();
      ASSERT_GT((X * scene::support_of(piece, down)).z(), -0.5e-3)
          << name_of(static_cast<PieceShape>(i % kPieceShapes)) << " at " << step;
    }
    EXPECT_EQ(bench.world->penetration_faults(), 0u) << i;
  }
}

// A peg with 0.05 mm of clearance slides to the floor of its hole and comes out again: a cylinder
// in a tray's pocket, and a square peg between four boxes.
TEST(Parts, APegSlidesIntoItsHole) {
  for (const bool square : {false, true}) {
    auto scene = empty_scene();
    scene.physics.simplification = scene::Simplification::kOff;
    add_table(scene);
    const double clearance = 5e-5, depth = 0.012;
    Pose pose;
    pose.p.z() = 0.015 + 0.02 - 0.002;  // 2 mm in the hole
    if (square) {
      const double side = 0.02, wall = 0.02, half = 0.5 * side, out = half + 0.5 * wall;
      const double length = side + 2 * wall;
      add_fixture(scene, "hole",
                  {at(box(wall, length, 0.015), out, 0, 0.0075),
                   at(box(wall, length, 0.015), -out, 0, 0.0075),
                   at(box(side, wall, 0.015), 0, out, 0.0075),
                   at(box(side, wall, 0.015), 0, -out, 0.0075)});
      add_part(scene, "peg",
               part_type("square", {box(side - clearance, side - clearance, 0.04)}, 0.1), pose);
    } else {
      scene::TrayType tray;
      tray.name = "plate";
      tray.min_xy = {-0.04, -0.04};
      tray.max_xy = {0.04, 0.04};
      tray.thickness_m = 0.015;
      tray.mass_kg = 5;
      scene::Slot slot;
      slot.name = "hole";
      slot.pocket = {0.01, 0.01, depth};
      tray.slots.push_back(slot);
      scene.tray_types["plate"] = tray;
      add_tray(scene, "plate", "plate", {0, 0}, {});
      add_part(scene, "peg", part_type("round", {cylinder(0.01 - clearance / 2, 0.04)}, 0.1), pose);
    }
    const double floor = square ? 0.02 : 0.003 + 0.02;
    Bench bench(std::move(scene));
    bench.run(1500);
    EXPECT_NEAR(bench.X_WB("peg").translation().z(), floor, 2e-5) << square;
    EXPECT_LT(bench.X_WB("peg").translation().head<2>().norm(), 1e-4) << square;
    EXPECT_LT(bench.world->max_penetration_m(), 5e-5) << square;
  }
}

// The same gear of pieces: it rests as the gear does and tips with it.
TEST(Parts, AGearOfPiecesIsAsTheGear) {
  const scene::GearType gear = empty_scene().gear_types.at("d60");
  const double hub = gear.hub_height_m, disc = gear.disc_height_m, peg = gear.peg_top_m - disc;
  std::vector<api::Piece> pieces = {at(cylinder(gear.disc_radius_m, disc), 0, 0, 0.5 * disc),
                                    at(cylinder(gear.peg_radius_m, peg), 0, 0, disc + 0.5 * peg)};
  pieces.push_back(at({api::ConePiece{gear.hub_bottom_radius_m, gear.hub_top_radius_m, hub}, {}}, 0,
                      0, -0.5 * hub));
  for (const bool in_tray : {true, false}) {
    auto scene = empty_scene();
    add_table(scene);
    Pose pose;
    if (in_tray) {
      add_tray(scene, "tray", "d604", {0, 0}, {"s1=gear"});
      pose = scene.gears[0].X_WP;
      pose.p += Vector3d(0.08, 0, 1e-3);  // into the pocket of s2
    } else {
      Pose lying;
      lying.p = {0.3, 0, gear.disc_radius_m + 1e-3};
      lying.q = turned(std::numbers::pi / 2, Vector3d::UnitY());
      add_gear(scene, "gear", "d60", lying);
      pose = lying;
      pose.p.y() += 0.2;
    }
    add_part(scene, "part", part_type("union", pieces, gear.mass_kg), pose);
    Bench bench(std::move(scene));
    bench.run(2500);
    const Isometry3d X_gear = bench.X_WB("gear"), X_part = bench.X_WB("part");
    const auto tilt = [](const Isometry3d& X) { return std::acos(X.linear()(2, 2)); };
    EXPECT_NEAR(X_part.translation().z(), X_gear.translation().z(), in_tray ? 3e-6 : 2e-4);
    EXPECT_NEAR(tilt(X_part), tilt(X_gear), in_tray ? 1e-5 : 2e-3) << in_tray;
  }
}

struct GripCase {
  const char* name;
  scene::PadShape pad;
  scene::PartType type;
  double height_m;  // of the part's frame when it stands
};
void PrintTo(const GripCase& tested, std::ostream* out) { *out << tested.name; }

class PartGrip : public testing::TestWithParam<GripCase> {};

// Gripped by friction alone, lifted, carried and placed again.
TEST_P(PartGrip, IsPickedAndPlaced) {
  const GripCase& tested = GetParam();
  auto scene = empty_scene();
  add_table(scene);
  Pose pose;
  pose.p.z() = tested.height_m;
  add_part(scene, "part", tested.type, pose);
  constexpr double kUp = 0.05;
  add_hand(scene, {0, 0, 0.006 + kUp}).gripper.pad = tested.pad;
  Bench bench(std::move(scene));
  bench.run(150);
  bench.move({0, 0, -kUp}, 0.2);
  bench.grip(0);
  EXPECT_TRUE(bench.world->gripper(0).holding);
  EXPECT_EQ(bench.world->gripper(0).held_body, bench.index_of("part"));
  bench.move({0.05, 0.03, kUp}, 0.4);
  bench.run(100);
  EXPECT_GT(bench.X_WB("part").translation().z(), tested.height_m + 0.9 * kUp);
  const Isometry3d held = bench.X_TB("part");
  bench.run(1000);
  EXPECT_LT((bench.X_TB("part").translation() - held.translation()).norm(), 1e-5);
  bench.move({0, 0, -kUp}, 0.3);
  bench.grip(1);
  EXPECT_FALSE(bench.world->gripper(0).holding);
  bench.move({0, 0, kUp}, 0.3);
  bench.run(500);
  const Vector3d placed = bench.X_WB("part").translation();
  EXPECT_NEAR(placed.x(), 0.05, 1e-3);
  EXPECT_NEAR(placed.y(), 0.03, 1e-3);
  EXPECT_NEAR(placed.z(), tested.height_m, 2e-5);
  EXPECT_EQ(bench.world->penetration_faults(), 0u);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, PartGrip,
    testing::Values(GripCase{"flat_box", scene::PadShape::kFlat,
                             part_type("box", {box(0.02, 0.012, 0.03)}, 0.1), 0.015},
                    GripCase{"flat_cylinder", scene::PadShape::kFlat,
                             part_type("cylinder", {cylinder(0.006, 0.03)}, 0.1), 0.015},
                    GripCase{"v_cylinder", scene::PadShape::kV,
                             part_type("cylinder", {cylinder(0.006, 0.03)}, 0.1), 0.015},
                    GripCase{"v_box", scene::PadShape::kV,
                             part_type("box", {box(0.02, 0.012, 0.03)}, 0.1), 0.015},
                    GripCase{"flat_prism", scene::PadShape::kFlat,
                             part_type("nut",
                                       {{api::PrismPiece{{{0.007, 0},
                                                          {0.0035, 0.006},
                                                          {-0.0035, 0.006},
                                                          {-0.007, 0},
                                                          {-0.0035, -0.006},
                                                          {0.0035, -0.006}},
                                                         0.03},
                                         {}}},
                                       0.1),
                             0.015},
                    GripCase{"flat_ball_on_stem", scene::PadShape::kFlat,
                             part_type("stem",
                                       {cylinder(0.008, 0.01), at(ball(0.006), 0, 0, 0.011)}, 0.05),
                             0.005}),
    [](const auto& tested) { return std::string(tested.param.name); });

// A cup holds on a flat face, and leaks on a ball.
TEST(Parts, ACupHoldsOnFlatFaces) {
  for (const bool flat : {true, false}) {
    auto scene = empty_scene();
    add_table(scene);
    const double half = flat ? 0.01 : 0.015;
    Pose pose;
    pose.p.z() = half;
    add_part(scene, "part", part_type("part", {flat ? box(0.04, 0.04, 2 * half) : ball(half)}, 0.1),
             pose);
    constexpr double kUp = 0.05, kPress = 2e-4;
    scene::Gripper& gripper = add_hand(scene, {0, 0, 2 * half + kUp}).gripper;
    gripper.cup = scene::VacuumCup{.radius_m = 0.008,
                                   .max_vacuum_pa = 60e3,
                                   .free_flow_m3_s = 2e-4,
                                   .evacuation_s = 0.02,
                                   .lip_compliance_m = 5e-4};
    gripper.pad_height_m = 0.03;
    Bench bench(std::move(scene));
    bench.run(100);
    bench.world->set_gripper(0, 0);
    bench.move({0, 0, -kUp - kPress}, 0.3);
    bench.run(200);
    bench.move({0, 0, kUp}, 0.5);
    bench.run(300);
    EXPECT_EQ(bench.X_WB("part").translation().z() > half + 0.9 * kUp, flat);
    EXPECT_EQ(bench.world->gripper(0).holding, flat);
  }
}

// Nothing is caught where the pieces of a floor meet: a box slides over the seams as over a plate.
TEST(Parts, SeamsOfPiecesHoldNothing) {
  auto scene = empty_scene();
  scene.physics.simplification = scene::Simplification::kOff;
  std::vector<api::Piece> tiles;
  for (int i = 0; i < 20; ++i) tiles.push_back(at(box(0.05, 1, 0.02), 0.05 * i, 0, -0.01));
  scene::PartType floor = part_type("floor", tiles, 50);
  Pose level;
  level.p.z() = 0;
  Pose table;
  table.p = {0.5, 0, -0.07};
  scene.fixed.push_back({"table", {3, 3, 0.1}, table});
  add_part(scene, "floor", floor, level);
  Pose pose;
  pose.p = {0.05, 0.1, 0.01};
  pose.q = turned(0.3, Vector3d::UnitZ());
  add_part(scene, "box", part_type("box", {box(0.03, 0.03, 0.02)}, 0.1), pose);
  Bench bench(std::move(scene));
  bench.run(100);
  const double x = bench.X_WB("box").translation().x(), v = 1.5, mu = 0.3;
  bench.world->set_velocity(bench.index_of("box"), {v, 0, 0}, Vector3d::Zero());
  bench.run(800);
  const double far = v * v / (2 * mu * kGravity);
  EXPECT_NEAR(bench.X_WB("box").translation().x() - x, far, 0.01 * far);
  EXPECT_NEAR(bench.X_WB("box").translation().z(), 0.01, 1e-4);
}

/// A bin with its inside above z = 0, walls of 10 mm.
std::vector<api::Piece> bin_pieces(double width_m, double height_m) {
  const double wall = 0.01, out = 0.5 * (width_m + wall), length = width_m + 2 * wall;
  return {at(box(length, length, wall), 0, 0, -0.5 * wall),
          at(box(wall, length, height_m), out, 0, 0.5 * height_m),
          at(box(wall, length, height_m), -out, 0, 0.5 * height_m),
          at(box(width_m, wall, height_m), 0, out, 0.5 * height_m),
          at(box(width_m, wall, height_m), 0, -out, 0.5 * height_m)};
}

TEST(Parts, ABinOfFortySettles) {
  std::mt19937_64 random(12);
  std::normal_distribution<double> normal;
  auto scene = empty_scene();
  constexpr double kWidth = 0.2;
  add_fixture(scene, "bin", bin_pieces(kWidth, 0.3));
  for (int i = 0; i < 40; ++i) {
    const std::string name = "p" + std::to_string(i);
    std::vector<api::Piece> pieces{
        random_piece(static_cast<PieceShape>(i % kPieceShapes), 0.013, random)};
    if (i % 3 == 0) {
      pieces.push_back(random_piece(PieceShape::kCylinder, 0.009, random));
      const double top = scene::bounds_of(std::span(pieces).first(1)).max().z();
      pieces[1].X_BP.p.z() = top - scene::bounds_of(std::span(pieces).last(1)).min().z();
    }
    Pose pose;
    pose.p = {0.066 * (i % 3) - 0.066, 0.066 * (i / 3 % 3) - 0.066, 0.05 + 0.065 * (i / 9)};
    const double w = normal(random), x = normal(random), y = normal(random);
    pose.q = Quaterniond(w, x, y, normal(random)).normalized();
    add_part(scene, name, part_type(name, pieces, 0.05), pose);
  }
  Bench bench(std::move(scene));
  // While they fall on each other few contacts are deeper for a step or two; the heap is not.
  bench.run(2000);
  EXPECT_LE(bench.world->penetration_faults(), 8u);
  const auto before = bench.world->penetration_faults();
  double deepest = 0;
  for (int i = 0; i < 1000; ++i) {
    bench.run(1);
    deepest = std::max(deepest, bench.world->max_penetration_m());
  }
  EXPECT_LT(deepest, 0.5e-3);
  EXPECT_EQ(bench.world->penetration_faults(), before);
  for (int i = 0; i < 40; ++i) {
    const BodyState body = bench.world->body(i);
    EXPECT_LT(body.v_W.norm(), 0.02) << i;
    EXPECT_LT(body.p_WB.head<2>().cwiseAbs().maxCoeff(), 0.5 * kWidth) << i;
    EXPECT_GT(body.p_WB.z(), 0) << i;
  }
}

TEST(Parts, ASavedStateGoesOnTheSame) {
  auto scene = empty_scene();
  add_table(scene);
  int i = 0;
  for (const Standing& part : standing_parts()) {
    Pose pose;
    pose.p = {0.1 * i, 0, standing_height(part) + 0.02};
    pose.q = part.q;
    scene::PartType type = part.type;
    type.name += std::to_string(i);
    add_part(scene, type.name, type, pose);
    ++i;
  }
  Bench first(scene), second(scene);
  first.run(60);
  second.world->restore(first.world->save());
  first.run(300);
  second.run(300);
  EXPECT_EQ(first.world->state_hash(), second.world->state_hash());
}

TEST(Parts, RestWithOdeAsWell) {
  for (const Standing& part : standing_parts()) {
    auto scene = empty_scene();
    scene.physics.engine = scene::PhysicsEngine::kOde;
    add_table(scene);
    Pose pose;
    pose.q = part.q;
    pose.p.z() = standing_height(part) + 1e-3;
    add_part(scene, "part", part.type, pose);
    Bench bench(std::move(scene));
    bench.run(1000);
    EXPECT_NEAR(bench.X_WB("part").translation().z(), standing_height(part), 1e-4) << part.name;
  }
}

TEST(Parts, MaterialsDecideHowTheySlide) {
  for (const double mu : {0.1, 0.3}) {
    auto scene = empty_scene();
    scene.physics.simplification = scene::Simplification::kOff;
    scene.physics.materials.push_back({"ice", "steel", mu, 0, 0, 0});
    add_fixture(scene, "plate", {at(box(4, 4, 0.1), 0, 0, -0.05)});
    scene.fixtures.back().material = "steel";
    scene::PartType type = part_type("puck", {cylinder(0.03, 0.02)}, 0.2);
    type.material = "ice";
    Pose pose;
    pose.p.z() = 0.01;
    add_part(scene, "puck", type, pose);
    Bench bench(std::move(scene));
    bench.run(100);
    const double x = bench.X_WB("puck").translation().x();
    bench.world->set_velocity(0, {1, 0, 0}, Vector3d::Zero());
    bench.run(1500);
    const double far = 1 / (2 * mu * kGravity);
    EXPECT_NEAR(bench.X_WB("puck").translation().x() - x, far, 0.01 * far) << mu;
  }
}

}  // namespace
}  // namespace aprsim::physics::test
