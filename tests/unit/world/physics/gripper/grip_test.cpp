#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"
#include "world/physics/constraint/constraint_system.hpp"
#include "world/physics/gripper/gripper_mechanism.hpp"

namespace aprsim::physics::test {
namespace {

constexpr double kAboveDisc = 3.5e-3;  // finger tips over the disc in a pick
constexpr double kLift = 0.05;

double pitch_of(const std::string& gear) {
  return gear == "small" ? 0.045 : gear[0] == 'd' ? 0.04 : 0.05;
}

/// Two trays, gear "g" in a slot of the first, the same slot of the second empty; a hand over "g",
/// off by (across, along) in its own x and y.
scene::Scene pick_scene(const std::string& gear, const Eigen::Vector2d& off = {0, 0},
                        double yaw = 0) {
  auto scene = empty_scene();
  add_table(scene);
  add_tray(scene, "a", gear + "4", {0, 0}, {"s1=g", "s2=n2", "s3=n3", "s4=n4"});
  add_tray(scene, "b", gear + "4", {0.3, 0}, {"s2=m2", "s3=m3", "s4=m4"});
  const double pitch = pitch_of(gear);
  const Eigen::Vector2d at = Eigen::Vector2d(-pitch, pitch) + Eigen::Rotation2Dd(yaw) * off;
  const double tip = 0.015 + scene.gear_types.at(gear).disc_height_m + kAboveDisc;
  add_hand(scene, {at.x(), at.y(), tip + kLift}, yaw);
  return scene;
}

struct Outcome {
  Eigen::Isometry3d X_TG_closed, X_TG_carried;
  double pop_m = 0, hop_m = 0;  // rise of gear and tray while closing and lifting off
  bool held = false;
  Eigen::Vector3d place_error;
  [[nodiscard]] double slip() const {
    return (X_TG_carried.translation() - X_TG_closed.translation()).norm();
  }
};

Outcome pick(Bench& bench) {
  Outcome out;
  bench.run(120);
  bench.move({0, 0, -kLift}, 0.15);
  const double gear_z = bench.X_WB("g").translation().z();
  const double tray_z = bench.X_WB("a").translation().z();
  bench.world->set_gripper(0, 0);
  for (int i = 0; i < 500 && !bench.world->gripper(0).settled; ++i) {
    bench.run(1);
    out.pop_m = std::max(out.pop_m, bench.X_WB("g").translation().z() - gear_z);
  }
  bench.run(50);
  out.X_TG_closed = bench.X_TB("g");
  bench.move({0, 0, kLift}, 0.2);
  out.hop_m = bench.X_WB("a").translation().z() - tray_z;
  out.held = bench.world->gripper(0).holding &&
             bench.world->gripper(0).held_body == bench.index_of("g") &&
             bench.X_WB("g").translation().z() > 0.06;
  return out;
}

void shake(Bench& bench) {
  const Eigen::Isometry3d start = bench.X_WT;
  for (int i = 1; i <= 400; ++i) {
    const double t = i * 1e-3, w = 2 * std::numbers::pi * 8, a = 3e-3;  // up to 7.6 m/s^2
    Eigen::Isometry3d next = start;
    next.translation() +=
        a * Eigen::Vector3d(std::sin(w * t), 1 - std::cos(w * t), std::sin(0.5 * w * t));
    bench.step_tool(next);
  }
}

/// Over the empty slot of tray b, corrected for where the gear really is, down, open, away.
void place(Bench& bench, const std::string& gear, Outcome& out,
           const Eigen::Vector3d& error = Eigen::Vector3d::Zero()) {
  bench.run(200);  // the mount comes to rest after shaking
  const Eigen::Vector3d slot(-pitch_of(gear), pitch_of(gear), 0);
  const Eigen::Vector3d goal = bench.X_WB("b") * slot + error;
  Eigen::Vector3d way = goal - bench.X_WB("g").translation();
  bench.move({way.x(), way.y(), 0}, 0.4);
  out.X_TG_carried = bench.X_TB("g");
  way = goal - bench.X_WB("g").translation();
  bench.move({0, 0, way.z() + 1e-4}, 0.4);
  bench.run(50);
  bench.grip(1);
  bench.move({0, 0, kLift}, 0.15);
  bench.run(100);
  out.place_error = bench.X_WB("b").inverse() * bench.X_WB("g").translation() - slot;
}

class PickAndPlace : public testing::TestWithParam<
                         std::tuple<const char*, scene::PadShape, scene::Simplification>> {};

TEST_P(PickAndPlace, HoldsByFrictionAloneAndSetsDownInPlace) {
  const auto [gear, pad, simplification] = GetParam();
  auto scene = pick_scene(gear);
  scene.robots[0].gripper.pad = pad;
  scene.physics.simplification = simplification;
  Bench bench(std::move(scene));
  Outcome out = pick(bench);
  ASSERT_TRUE(out.held);
  EXPECT_NEAR(bench.world->gripper(0).force_n[0], 60, 1);
  EXPECT_NEAR(bench.world->gripper(0).force_n[1], 60, 1);
  EXPECT_LT(out.pop_m, 30e-6);
  EXPECT_LT(std::abs(out.hop_m), 30e-6);
  shake(bench);
  place(bench, gear, out);
  EXPECT_LT(out.slip(), 2e-6);
  EXPECT_LT(angle_between(out.X_TG_closed, out.X_TG_carried), 1e-4);
  EXPECT_LT(out.place_error.norm(), 0.3e-3);
  EXPECT_FALSE(bench.world->gripper(0).holding);
  EXPECT_EQ(bench.world->penetration_faults(), 0u);
  EXPECT_TRUE(bench.world->body(bench.index_of("g")).resting);
}

INSTANTIATE_TEST_SUITE_P(Gears, PickAndPlace,
                         testing::Combine(testing::Values("small", "medium", "d60"),
                                          testing::Values(scene::PadShape::kV,
                                                          scene::PadShape::kFlat),
                                          testing::Values(scene::Simplification::kDormant,
                                                          scene::Simplification::kOff)));

class OffCentre
    : public testing::TestWithParam<std::tuple<scene::PadShape, double, double, double>> {};

// The fingers close up to 2 mm beside the peg, along the closing direction and across it: the tray
// gives way, V pads centre the peg both ways, flat ones along the closing direction. A peg that
// slides along a groove's face has no friction left against tipping: within its slot's clearance
// the gear tilts by up to 3 mrad, which is some 0.1 mm, with steps of 1 ms as of 0.125 ms.
TEST_P(OffCentre, PickSucceedsAndVPadsCentreThePeg) {
  const auto [pad, across, along, yaw] = GetParam();
  auto scene = pick_scene("d60", {across, along}, yaw);
  scene.robots[0].gripper.pad = pad;
  auto& mu = scene.physics.friction;
  mu.gear_tray = mu.tray_ground = mu.gear_gear = scene.robots[0].gripper.pad_friction = 0.6;
  Bench bench(std::move(scene));
  Outcome out = pick(bench);
  ASSERT_TRUE(out.held);
  EXPECT_LT(out.pop_m, 110e-6);
  EXPECT_EQ(bench.world->penetration_faults(), 0u);
  const Eigen::Vector3d in_hand = out.X_TG_closed.translation();
  EXPECT_LT(std::abs(in_hand.y()), 30e-6);
  const bool v = pad == scene::PadShape::kV;
  EXPECT_NEAR(in_hand.x(), v ? 0 : -across, v ? 5e-6 : 40e-6);
  shake(bench);
  place(bench, "d60", out);
  EXPECT_LT(out.slip(), 2e-6);
  EXPECT_LT(angle_between(out.X_TG_closed, out.X_TG_carried), 1e-4);
  EXPECT_LT(out.place_error.head<2>().norm(), 10e-6);
}

INSTANTIATE_TEST_SUITE_P(
    Grid, OffCentre,
    testing::Combine(testing::Values(scene::PadShape::kV, scene::PadShape::kFlat),
                     testing::Values(-2e-3, 5e-4), testing::Values(-2e-3, 1e-3),
                     testing::Values(0.0, 0.7854)));

// Pads and wall hold a light gear against tipping above a friction of about 0.35, by a balance of
// moments, and not far below it.
TEST(Tipping, FrictionDecidesWhetherAGearTipsAtAnOffCentreClose) {
  const auto pop = [](double friction) {
    auto scene = pick_scene("d50", {0, 2e-3}, 0.7854);
    auto& gripper = scene.robots[0].gripper;
    gripper.pad = scene::PadShape::kFlat;
    gripper.finger_speed_m_s = 0.3;
    auto& mu = scene.physics.friction;
    mu.gear_tray = mu.tray_ground = mu.gear_gear = gripper.pad_friction = friction;
    Bench bench(std::move(scene));
    return pick(bench).pop_m;
  };
  EXPECT_GT(pop(0.2), 500e-6);
  EXPECT_LT(pop(0.4), 40e-6);  // 20 um of it are the depth at which it rested
}

// Without friction on the pads nothing can be carried: there is no hidden attachment.
TEST(NoAttachment, SlipperyPadsLeaveTheGearBehind) {
  auto scene = pick_scene("small");
  scene.robots[0].gripper.pad_friction = 0;
  Bench bench(std::move(scene));
  pick(bench);
  EXPECT_LT(bench.X_WB("g").translation().z(), 0.02);
}

TEST(NoAttachment, OpeningInTheAirDropsTheGear) {
  Bench bench(pick_scene("small"));
  ASSERT_TRUE(pick(bench).held);
  bench.world->set_gripper(0, 1);
  bench.run(300);
  EXPECT_LT(bench.X_WB("g").translation().z(), 0.03);
  EXPECT_FALSE(bench.world->gripper(0).holding);
}

// Weak pads hold a gear at rest and lose it when the arm pulls up harder than friction can follow:
// 2 mu F = 0.32 N carries 10.2 g up to 21.6 m/s^2 in all.
TEST(NoAttachment, AccelerationBeyondFrictionLosesTheGear) {
  for (const double accel : {8.0, 40.0}) {
    auto scene = pick_scene("small");
    scene.robots[0].gripper.pad = scene::PadShape::kFlat;
    scene.robots[0].gripper.force_n = 0.2;
    Bench bench(std::move(scene));
    bench.run(120);
    bench.move({0, 0, -kLift}, 0.15);
    bench.grip(0);
    const Eigen::Isometry3d before = bench.X_TB("g");
    const Eigen::Isometry3d start = bench.X_WT;
    for (int i = 1; i <= 100; ++i) {
      Eigen::Isometry3d next = start;
      next.translation().z() += 0.5 * accel * i * i * 1e-6;
      bench.step_tool(next);
    }
    const double slip = (bench.X_TB("g").translation() - before.translation()).norm();
    if (accel < 10) {
      EXPECT_LT(slip, 50e-6);
    } else {
      EXPECT_GT(slip, 5e-3);
    }
  }
}

// Fig. 3 of the paper: displacement along the finger axis under acceleration, by controller.
TEST(Controllers, LinkageBeatsCoupledBeatsConstantAlongTheFingers) {
  const auto shaken = [](scene::GripperLaw law) {
    auto scene = pick_scene("d60");
    scene.robots[0].gripper.law = law;
    scene.robots[0].gripper.pad = scene::PadShape::kFlat;
    Bench bench(std::move(scene));
    EXPECT_TRUE(pick(bench).held);
    const Eigen::Isometry3d before = bench.X_TB("g");
    const Eigen::Isometry3d start = bench.X_WT;
    double worst = 0;
    for (int i = 1; i <= 100; ++i) {  // 10 m/s^2 along the finger axis
      Eigen::Isometry3d next = start;
      next.translation().y() += 0.5 * 10 * i * i * 1e-6;
      bench.step_tool(next);
      worst = std::max(worst, (bench.X_TB("g").translation() - before.translation()).norm());
    }
    return worst;
  };
  const double constant = shaken(scene::GripperLaw::kConstant);
  const double coupled = shaken(scene::GripperLaw::kCoupled);
  const double linkage = shaken(scene::GripperLaw::kLinkage);
  EXPECT_GT(constant, 1e-3);
  EXPECT_LT(coupled, 0.25e-3);
  EXPECT_LT(linkage, 1e-6);
}

// A gripper's state is plain values: restored, it continues bit for bit.
TEST(Gripper, SavedStateComesBackBitForBit) {
  auto scene = empty_scene();
  for (const auto law : {scene::GripperLaw::kLinkage, scene::GripperLaw::kMimicPid}) {
    add_hand(scene, {0, 0, 0.5});
    scene.robots[0].gripper.law = law;
    scene.robots[0].gripper.fill_time_s = 0.02;
    const Eigen::Isometry3d X_WF = scene.robots[0].X_WB.isometry();
    GripperMechanism hand(scene.robots[0].gripper, scene.physics, X_WF);
    ConstraintSystem system;
    hand.attach(X_WF, scene.robots[0].X_FT.isometry());
    hand.command(0);
    const auto advance = [&](int steps) {
      for (int i = 0; i < steps; ++i) {
        hand.begin_step(X_WF);
        system.begin({});
        hand.add_to(system);
        system.advance();
        hand.end_step();
        hand.observe({}, false);
      }
    };
    advance(40);
    const GripperMechanism::State middle = hand.save();
    advance(30);
    const GripperState first = hand.state();
    EXPECT_NE(first.travel_m[0], middle.report.travel_m[0]);
    hand.restore(middle);
    advance(30);
    EXPECT_EQ(hand.state().travel_m, first.travel_m);
    EXPECT_EQ(hand.state().palm_deflection_m, first.palm_deflection_m);
    scene.robots.clear();
  }
}

// At a fifth of the supply's force and with slow chambers: the pads press with what the air gives.
TEST(Gripper, AirPressureAndFillTimeDecideForceAndTime) {
  const auto closing_time = [](double fill_time_s, double leak_per_s, double expected_n) {
    auto scene = pick_scene("d60");
    scene.robots[0].gripper.fill_time_s = fill_time_s;
    scene.robots[0].gripper.leak_per_s = leak_per_s;
    Bench bench(std::move(scene));
    bench.run(120);
    bench.move({0, 0, -kLift}, 0.15);
    bench.world->set_gripper(0, 0);
    int steps = 0;
    while (!bench.world->gripper(0).settled && steps < 1000) bench.run(1), ++steps;
    bench.run(50);
    EXPECT_NEAR(bench.world->gripper(0).force_n[0], expected_n, 0.02 * expected_n);
    return steps;
  };
  const int fast = closing_time(0, 0, 60);
  const int slow = closing_time(0.05, 0, 60);
  EXPECT_GT(slow, fast + 30);  // ln 2 of the fill time until the net force turns round
  EXPECT_LT(slow, 1000);
  closing_time(0.01, 400, 12);
}

TEST(Gripper, ClosingOnNothingEndsAtTheStopWithoutHolding) {
  auto scene = empty_scene();
  add_hand(scene, {0, 0, 0.5});
  Bench bench(std::move(scene));
  bench.grip(0);
  EXPECT_TRUE(bench.world->gripper(0).settled);
  EXPECT_FALSE(bench.world->gripper(0).holding);
  EXPECT_NEAR(bench.world->gripper(0).separation_m, 0.002, 20e-6);
  bench.grip(1);
  EXPECT_NEAR(bench.world->gripper(0).separation_m, 0.022, 20e-6);
  EXPECT_NEAR(bench.world->gripper(0).travel_m[0], 0, 10e-6);
}

// But for what the fingers' inertia bends the mount.
TEST(Gripper, FollowsTheFlangeWithoutLagUnderAcceleration) {
  auto scene = empty_scene();
  const auto gripper = add_hand(scene, {0, 0, 0.5}).gripper;
  const double most_accel = 10;
  Bench bench(std::move(scene));
  bench.world->set_gripper(0, 0);  // moving fingers keep the mechanism in the solver
  double worst = 0;
  const Eigen::Isometry3d start = bench.X_WT;
  for (int i = 1; i <= 60; ++i) {
    Eigen::Isometry3d next = start;
    next.translation().x() += 0.5 * most_accel * i * i * 1e-6;
    next.linear() = Eigen::AngleAxisd(0.01 * i, Eigen::Vector3d::UnitZ()) * start.linear();
    bench.step_tool(next);
    worst = std::max(worst, (bench.world->gripper(0).X_WT.p - bench.X_WT.translation()).norm());
  }
  const double inertia_n = 2 * gripper.finger_mass_kg * most_accel;
  EXPECT_LT(worst, 2 * inertia_n / gripper.palm_stiffness_n_m);  // twice: it comes suddenly
}

// Fingers pressed on a disc: the mount gives way as its spring says, the arm feels it.
TEST(Gripper, PressingDownLoadsTheMountAndTheArm) {
  auto scene = empty_scene();
  add_table(scene);
  add_hand(scene, {0, 0, 0.02});
  Bench bench(std::move(scene));
  bench.move({0, 0, -0.022}, 0.2);  // 2 mm into the table
  bench.run(100);
  EXPECT_NEAR(bench.world->gripper(0).palm_deflection_m, 2e-3, 0.05e-3);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& force : bench.world->arm_forces(0)) {
    EXPECT_EQ(force.link, 1);
    EXPECT_EQ(name_of(bench.scene, *bench.world, force.partner), "table");
    sum += force.f_W;
  }
  EXPECT_NEAR(sum.z(), 10, 0.3);  // 5 kN/m times 2 mm
  EXPECT_NEAR(sum.head<2>().norm(), 0, 0.3);
}

/// Wrench of the contacts on the arm, about a point.
struct Load {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero(), moment_nm = Eigen::Vector3d::Zero();
};

Load load_on_arm(const Bench& bench, const Eigen::Vector3d& about_W) {
  Load load;
  for (const auto& force : bench.world->arm_forces(0)) {
    if (force.relayed) continue;
    EXPECT_TRUE(force.on_gripper);
    load.force_n += force.f_W;
    load.moment_nm += (force.p_W - about_W).cross(force.f_W);
  }
  return load;
}

Eigen::Vector3d com_of(const Bench& bench, const std::string& body) {
  const BodyState state = bench.world->body(bench.index_of(body));
  return state.p_WB;  // of a gear of even density, a few millimetres off at most
}

/// A gear of the shape of d60 and that mass in the hand, lifted.
class Heavy : public testing::TestWithParam<double> {
 protected:
  static scene::Scene scene_with(double kg) {
    auto scene = pick_scene("d60");
    scene.gear_types.at("d60").mass_kg = kg;
    scene.robots[0].gripper.pad = scene::PadShape::kFlat;
    return scene;
  }
};

// The grip's own forces cancel; what is left is the weight, at the gear's centre of mass, and it
// bends the mount.
TEST_P(Heavy, WeightLoadsArmAndMount) {
  const double kg = GetParam(), weight = kg * 9.81;
  Bench bench(scene_with(kg));
  ASSERT_TRUE(pick(bench).held);
  bench.run(300);
  const Load load = load_on_arm(bench, com_of(bench, "g"));
  EXPECT_NEAR(load.force_n.z(), -weight, 0.01 * weight);
  EXPECT_LT(load.force_n.head<2>().norm(), 0.01 * weight);
  EXPECT_LT(load.moment_nm.head<2>().norm(), 0.002 * weight) << "acts on a vertical through it";
  const double sag = weight / bench.scene.robots[0].gripper.palm_stiffness_n_m;
  EXPECT_NEAR(bench.world->gripper(0).palm_deflection_m, sag, 0.02 * sag + 1e-7);
}

// In motion its inertia adds: the force on the arm is m (g - a), whatever the direction.
TEST_P(Heavy, InertiaLoadsTheArm) {
  const double kg = GetParam();
  for (const Eigen::Vector3d& a :
       {Eigen::Vector3d(0, 0, 20), Eigen::Vector3d(20, 0, 0), Eigen::Vector3d(0, -8, 5)}) {
    Bench bench(scene_with(kg));
    ASSERT_TRUE(pick(bench).held);
    bench.run(300);
    const Eigen::Isometry3d start = bench.X_WT;
    const BodyState before = bench.world->body(bench.index_of("g"));
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    constexpr int kFirst = 60, kSteps = 160;
    Eigen::Vector3d v_first = before.v_W;
    for (int i = 1; i <= kSteps; ++i) {
      Eigen::Isometry3d next = start;
      next.translation() += 0.5 * a * i * i * 1e-6;
      bench.step_tool(next);
      if (i == kFirst) v_first = bench.world->body(bench.index_of("g")).v_W;
      if (i > kFirst) mean += load_on_arm(bench, {0, 0, 0}).force_n / (kSteps - kFirst);
    }
    // Newton's second law for the gear itself, whose acceleration is the arm's in the mean.
    const Eigen::Vector3d v = bench.world->body(bench.index_of("g")).v_W;
    const Eigen::Vector3d own = (v - v_first) / ((kSteps - kFirst) * 1e-3);
    const Eigen::Vector3d g(0, 0, -9.81);
    EXPECT_LT((mean - kg * (g - own)).norm(), 0.01 * (kg * (g - own)).norm());
    EXPECT_LT((own - a).norm(), 0.05 * a.norm());
  }
}

INSTANTIATE_TEST_SUITE_P(Masses, Heavy, testing::Values(0.02, 1.0));

// A hanging gear loads the arm with its weight through the pads. Pushed onto the table it also
// transmits the table's force, which is reported with the table's name.
TEST(Gripper, CollisionOfAHeldGearLoadsTheArmThroughThePads) {
  Bench bench(pick_scene("small"));
  ASSERT_TRUE(pick(bench).held);
  bench.run(50);
  const double weight = bench.scene.gear_types.at("small").mass_kg * 9.81;
  EXPECT_NEAR(load_on_arm(bench, {0, 0, 0}).force_n.z(), -weight, 0.01 * weight);
  for (const auto& force : bench.world->arm_forces(0)) {
    EXPECT_FALSE(force.relayed) << "it meets nothing";
    EXPECT_EQ(name_of(bench.scene, *bench.world, force.partner), "g");
  }
  bench.move({-0.2, 0, 0}, 0.4);
  // Hub's underside at 3 mm over the table after this much; press 1 mm.
  const double down = bench.X_WB("g").translation().z() - 0.012 + 1e-3;
  bench.move({0, 0, -down}, 0.4);
  bench.run(50);
  EXPECT_NEAR(load_on_arm(bench, {0, 0, 0}).force_n.z(), 5 - 0.1, 0.5);
  double table = 0;
  for (const auto& force : bench.world->arm_forces(0)) {
    if (!force.relayed) continue;
    EXPECT_EQ(name_of(bench.scene, *bench.world, force.partner), "table");
    table += force.f_W.z();
  }
  EXPECT_NEAR(table, 5, 0.5);
}

/// A bar as a tray, narrow enough for the fingers, and a hand over it.
scene::Scene bar_scene(scene::Simplification mode) {
  auto scene = empty_scene();
  scene.physics.simplification = mode;
  add_table(scene);
  scene::TrayType bar;
  bar.name = "bar";
  bar.kind = api::BodyKind::kKitTray;
  bar.min_xy = {-0.05, -0.006};
  bar.max_xy = {0.05, 0.006};
  bar.thickness_m = 0.02;
  bar.mass_kg = 0.15;
  scene.tray_types["bar"] = bar;
  add_tray(scene, "other", "small4", {0.4, 0}, {"s1=g"});
  add_tray(scene, "bar", "bar", {0, 0}, {});
  add_hand(scene, {0, 0, 0.006 + kLift});
  return scene;
}

class HeldTray : public testing::TestWithParam<scene::Simplification> {};

TEST_P(HeldTray, IsToldByItsIndexAndLoadsTheArm) {
  Bench bench(bar_scene(GetParam()));
  bench.run(120);
  bench.move({0, 0, -kLift}, 0.15);
  EXPECT_FALSE(bench.world->gripper(0).holding);
  bench.grip(0);
  EXPECT_TRUE(bench.world->gripper(0).holding) << "already on the table";
  bench.move({0, 0, kLift}, 0.3);
  bench.run(200);
  const GripperState& hand = bench.world->gripper(0);
  EXPECT_TRUE(hand.holding);
  EXPECT_EQ(hand.held_body, bench.index_of("bar"));
  EXPECT_NEAR(hand.force_n[0], 60, 1.5);
  EXPECT_NEAR(hand.force_n[1], 60, 1.5);
  EXPECT_GT(bench.X_WB("bar").translation().z(), 0.05);
  const double weight = 0.15 * 9.81;
  EXPECT_NEAR(load_on_arm(bench, {0, 0, 0}).force_n.z(), -weight, 0.01 * weight);
  bench.grip(1);
  bench.run(300);
  EXPECT_FALSE(bench.world->gripper(0).holding);
  EXPECT_EQ(bench.world->gripper(0).held_body, -1);
}

// A finger that stands on a tray, or beside it, holds nothing.
TEST_P(HeldTray, PressingOnATrayIsNoHold) {
  auto scene = bar_scene(GetParam());
  scene.tray_types.at("bar").min_xy.y() = -0.04;
  scene.tray_types.at("bar").max_xy.y() = 0.04;
  Bench bench(std::move(scene));
  bench.run(120);
  bench.move({0, 0, -kLift + 0.014 - 0.001}, 0.2);  // 1 mm into its top
  bench.grip(0);
  EXPECT_FALSE(bench.world->gripper(0).holding);
  EXPECT_LT(bench.world->gripper(0).force_n[0], 5);
  EXPECT_LT(bench.world->gripper(0).force_n[1], 5);
}

INSTANTIATE_TEST_SUITE_P(Modes, HeldTray,
                         testing::Values(scene::Simplification::kOff,
                                         scene::Simplification::kVirtualJoints,
                                         scene::Simplification::kMerge,
                                         scene::Simplification::kDormant));

// Many contacts of one group.
TEST(Grip, ThePalmOnManyPegsIsSolvedExactly) {
  auto scene = empty_scene();
  add_table(scene);
  const scene::GearType& gear = scene.gear_types.at("d50");
  for (int i = 0; i < 25; ++i) {
    Pose pose;
    const int column = i % 5 - 2, line = i / 5 - 2;
    pose.p = {0.06 * column, 0.06 * line, gear.hub_height_m};
    add_gear(scene, "g" + std::to_string(i), "d50", pose);
  }
  auto& hand = add_hand(scene, {0, 0, 0.05});
  hand.gripper.palm_size = {0.4, 0.4, 0.08};
  hand.gripper.pad_height_m = 0.01;
  Bench bench(std::move(scene));
  bench.run(100);
  // The palm's face, 10 mm over the finger tips, comes down onto the pegs, fingers between them.
  bench.move({0.03, 0.03, 0}, 0.1);
  bench.move({0, 0, -(0.05 + 0.01 - gear.hub_height_m - gear.peg_top_m + 0.5e-3)}, 0.4);
  bench.run(20);
  EXPECT_EQ(bench.world->solver_failures(), api::SolverFailures{});
}

// Any opening where nothing is between the fingers; a part stops them before it.
TEST(Gripper, AServoGripperOpensProportionally) {
  auto scene = pick_scene("medium");
  auto& gripper = scene.robots[0].gripper;
  gripper.drive = scene::GripperDrive::kServo;
  Bench bench(std::move(scene));
  bench.run(120);
  for (const double setting : {0.5, 0.25, 0.75}) {
    bench.world->set_gripper(0, setting);
    bench.run(400);
    const GripperState& state = bench.world->gripper(0);
    EXPECT_TRUE(state.settled);
    EXPECT_NEAR(state.separation_m, 0.002 + 0.02 * setting, 2e-5) << setting;
    EXPECT_FALSE(state.holding);
  }
  bench.world->set_gripper(0, 1);
  bench.run(400);
  EXPECT_TRUE(pick(bench).held);
  EXPECT_NEAR(bench.world->gripper(0).force_n[0], 60, 1);
}

TEST(Gripper, LessForceIsSetWhileHoldingAndSurvivesSaving) {
  Bench bench(pick_scene("medium"));
  ASSERT_TRUE(pick(bench).held);
  bench.world->set_gripper_force(0, 25);
  bench.run(100);
  EXPECT_NEAR(bench.world->gripper(0).force_n[0], 25, 1);
  EXPECT_TRUE(bench.world->gripper(0).holding);
  const auto saved = bench.world->save();
  bench.world->set_gripper_force(0, 60);
  bench.run(100);
  EXPECT_NEAR(bench.world->gripper(0).force_n[0], 60, 1);
  bench.world->restore(saved);
  bench.run(100);
  EXPECT_NEAR(bench.world->gripper(0).force_n[0], 25, 1);
}

}  // namespace
}  // namespace aprsim::physics::test
