#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/cell_builder.hpp"
#include "world/physics/bodies/mass_properties.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kDeepest = 0.5e-3;  // [m]

Quaterniond any_turn(std::mt19937_64& engine) {
  std::normal_distribution<double> normal;
  const double w = normal(engine), x = normal(engine), y = normal(engine), z = normal(engine);
  return Quaterniond(w, x, y, z).normalized();
}

Pose at(const Vector3d& p, const Quaterniond& q = Quaterniond::Identity()) {
  Pose pose;
  pose.p = p;
  pose.q = q;
  return pose;
}

double lowest_z(const Bench& bench, const std::string& body) {
  const int index = bench.index_of(body);
  return bench.world->body(index).p_WB.z();
}

/// Obstacles of a gear that flies at 10 m/s.
struct Target {
  const char* name;
  void (*add)(scene::Scene&);
};
void PrintTo(const Target& shown, std::ostream* out) { *out << shown.name; }

void add_plate(scene::Scene& scene) {
  scene.fixed.push_back({"plate", {20, 20, 0.005}, at({0, 0, -0.0025})});
}
void add_belt_target(scene::Scene& scene) { add_belt(scene); }
void add_tray_target(scene::Scene& scene) {
  add_table(scene);
  add_tray(scene, "tray", "medium4", {0, 0}, {});
}
void add_full_tray(scene::Scene& scene) {
  add_table(scene);
  add_tray(scene, "tray", "medium4", {0, 0}, {"s1=a", "s2=b", "s3=c", "s4=d"});
}
void add_lying_gear(scene::Scene& scene) {
  add_table(scene);
  add_gear(scene, "lying", "large", at({0, 0, 0.02}));
}

class TenMetresPerSecond : public testing::TestWithParam<Target> {};

// From every attitude, at some distance from a step's whole way.
TEST_P(TenMetresPerSecond, NothingIsPassedOrEnteredDeeply) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const char* type : {"small", "medium", "d60"}) {
    for (int round = 0; round < 12; ++round) {
      auto scene = empty_scene();
      GetParam().add(scene);
      const Vector3d p(0.03 * unit(engine), 0.03 * unit(engine), 0.15 + 0.01 * unit(engine));
      add_gear(scene, "thrown", type, at(p, any_turn(engine)));
      Bench bench(std::move(scene));
      bench.run(100);
      // From where it has fallen to, back up.
      const int thrown = bench.index_of("thrown");
      const Vector3d spin(20 * unit(engine) - 10, 20 * unit(engine) - 10, 20 * unit(engine) - 10);
      bench.world->set_velocity(thrown, {0, 0, -10}, spin);
      double deepest = 0, least_z = 1;
      for (int step = 0; step < 400; ++step) {
        bench.run(1);
        deepest = std::max(deepest, bench.world->max_penetration_m());
        // A body that leaves the target's sides falls.
        const Vector3d now = bench.world->body(thrown).p_WB;
        if (now.head<2>().cwiseAbs().maxCoeff() < 0.1) least_z = std::min(least_z, now.z());
      }
      EXPECT_LT(deepest, kDeepest) << type << " " << round;
      EXPECT_GT(least_z, -1e-3) << type << " " << round;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, TenMetresPerSecond,
                         testing::Values(Target{"plate", add_plate},
                                         Target{"belt", add_belt_target},
                                         Target{"tray", add_tray_target},
                                         Target{"full_tray", add_full_tray},
                                         Target{"gear", add_lying_gear}),
                         [](const auto& target) { return std::string(target.param.name); });

// A finger is driven along its rail to its end, and the part comes after it.
/// A body that hits a slope is deflected to the side, against a wall outside of its former path.
TEST(Impact, DeflectedBodiesEnterNothingDeeply) {
  std::mt19937_64 engine(9);
  std::uniform_real_distribution<double> unit(0, 1);
  double deepest = 0;
  for (int round = 0; round < 200; ++round) {
    auto scene = empty_scene();
    const double slope = 0.6 + 0.4 * unit(engine), yaw = 6 * unit(engine);
    const Quaterniond turn(Eigen::AngleAxisd(yaw, Vector3d::UnitZ()));
    const Quaterniond q = turn * Quaterniond(Eigen::AngleAxisd(slope, Vector3d::UnitY()));
    scene.fixed.push_back({"slope", {0.4, 0.4, 0.05}, at(q * Vector3d(0, 0, -0.025), q)});
    const scene::GearType& type = scene.gear_types.at("medium");
    const double radius = type.disc_radius_m, gap = 2e-4 * unit(engine);
    scene.fixed.push_back(
        {"wall", {0.05, 0.4, 0.4}, at(turn * Vector3d(radius + gap + 0.025, 0, 0), turn)});
    const double high = radius * std::tan(slope) + 0.003 * unit(engine);
    add_gear(scene, "thrown", "medium", at({0, 0, high}));
    Bench bench(std::move(scene));
    const double speed = 0.1 * std::exp(2 * unit(engine));
    bench.world->set_velocity(bench.index_of("thrown"), {0, 0, -speed}, Vector3d::Zero());
    for (int step = 0; step < 60; ++step) {
      bench.run(1);
      deepest = std::max(deepest, bench.world->max_penetration_m());
    }
  }
  EXPECT_LT(deepest, 7e-5);
}

// Whichever side of a tray is up, and whoever strikes first.
TEST(Impact, APileThatFallsTogetherIsEnteredNowhereDeeply) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> unit(0, 1);
  double deepest = 0;
  for (int round = 0; round < 60; ++round) {
    auto scene = empty_scene();
    add_table(scene);
    const auto either_way_up = [&] {
      const double side = unit(engine) < 0.5 ? 0 : std::numbers::pi;
      const Quaterniond tilt(Eigen::AngleAxisd(0.3 * unit(engine), Vector3d::UnitY()));
      return tilt * Quaterniond(Eigen::AngleAxisd(side, Vector3d::UnitX()));
    };
    add_tray(scene, "tray", "medium4", {0, 0}, {});
    scene.trays.back().X_WP = at({0, 0, 0.06}, either_way_up());
    for (int i = 0; i < 3; ++i) {
      const double x = 0.06 * (unit(engine) - 0.5), y = 0.06 * (unit(engine) - 0.5);
      const char* type = i == 0 ? "large" : "medium";
      add_gear(scene, "gear" + std::to_string(i), type,
               at({x, y, 0.12 + 0.07 * i}, either_way_up()));
    }
    Bench bench(std::move(scene));
    for (int body = 0; body < bench.world->body_count(); ++body) {
      bench.world->set_velocity(body, {0, 0, -1.5 * (body + unit(engine))}, Vector3d::Zero());
    }
    for (int step = 0; step < 150; ++step) {
      bench.run(1);
      deepest = std::max(deepest, bench.world->max_penetration_m());
    }
  }
  EXPECT_LT(deepest, kDeepest);
}

TEST(Impact, AFingerThatIsStruckLetsNothingInWhenItStops) {
  for (const char* type : {"medium", "d60"}) {
    for (int phase = 0; phase < 20; ++phase) {
      auto scene = empty_scene();
      add_table(scene);
      const auto& hand = add_hand(scene, {0, 0, 0.3});
      const double middle = 0.3 + 0.5 * hand.gripper.pad_height_m, fallen = 0.0177;
      // Anywhere within a step's way.
      add_gear(scene, "thrown", type, at({0, 0.15 + 5e-4 * phase, middle + fallen}));
      Bench bench(std::move(scene));
      bench.run(60);
      const int thrown = bench.index_of("thrown");
      bench.world->set_velocity(thrown, {0, -10, 0}, Vector3d::Zero());
      double deepest = 0;
      for (int step = 0; step < 100; ++step) {
        bench.run(1);
        deepest = std::max(deepest, bench.world->max_penetration_m());
      }
      EXPECT_LT(deepest, 0.3e-3) << type << " " << phase;
      EXPECT_GT(bench.world->body(thrown).p_WB.y(), 0) << type << " " << phase;
    }
  }
}

class Rebound : public testing::TestWithParam<double> {};

// A tray that falls flat rises to e^2 of the height.
TEST_P(Rebound, RisesToTheSquareOfTheRestitution) {
  for (const double height : {0.05, 0.053, 0.058, 0.2, 0.325, 0.8}) {
    auto scene = empty_scene();
    add_table(scene);
    scene.physics.restitution.tray_ground = GetParam();
    add_tray(scene, "t", "small4", {0, 0}, {});
    const double thickness = scene.tray_types.at("small4").thickness_m;
    scene.trays[0].X_WP.p.z() = thickness + height;
    Bench bench(std::move(scene));
    double top = 0, before = height;
    bool struck = false;
    for (int step = 0; step < 2000; ++step) {
      bench.run(1);
      const double z = lowest_z(bench, "t") - thickness;
      if (struck) {
        top = std::max(top, z);
        if (z < before && z > 1e-3) break;
      }
      struck = struck || z >= before || z < 1e-3;
      before = z;
    }
    const double e = GetParam();
    EXPECT_NEAR(top, e * e * height, 0.02 * e * e * height + 2e-5) << height;
  }
}

// The same for a gear on the chamfered rim of its hub.
TEST_P(Rebound, OfAGearOnItsHub) {
  for (const double height : {0.0732073, 0.157125, 0.143372}) {
    auto scene = empty_scene();
    add_table(scene);
    scene.physics.restitution.gear_ground = GetParam();
    const double stands = scene.gear_types.at("large").hub_height_m;
    add_gear(scene, "g", "large", at({0, 0, stands + height}));
    Bench bench(std::move(scene));
    double top = 0;
    bool struck = false;
    for (int step = 0; step < 400; ++step) {
      bench.run(1);
      const BodyState state = bench.world->body(0);
      const double z = state.p_WB.z() - stands;
      if (struck && state.v_W.z() < 0) break;
      struck = struck || state.v_W.z() > 0;
      if (struck) top = std::max(top, z);
    }
    const double e = GetParam();
    EXPECT_NEAR(top, e * e * height, 0.005 * e * e * height + 1e-5) << height;
  }
}

INSTANTIATE_TEST_SUITE_P(Restitution, Rebound, testing::Values(0.0, 0.1, 0.3, 0.5, 0.7, 0.9));

// The reported work of the solver is that of the latest step, and part of the state.
TEST(SolverStep, IsThatOfTheLatestStep) {
  auto scene = empty_scene();
  add_table(scene);
  add_gear(scene, "g", "large", at({0, 0, 0.05}));
  Bench bench(std::move(scene));
  bench.run(1);
  EXPECT_EQ(bench.world->solver_step(), api::SolverStep{}) << "in the air";
  const auto in_the_air = bench.world->save();
  while (bench.world->contact_count() == 0) bench.run(1);
  const api::SolverStep struck = bench.world->solver_step();
  EXPECT_GT(struck.iterations, 0U);
  EXPECT_LE(struck.residual_m_s, 1e-8);
  const auto at_the_blow = bench.world->save();
  bench.world->restore(in_the_air);
  EXPECT_EQ(bench.world->solver_step(), api::SolverStep{});
  bench.world->restore(at_the_blow);
  EXPECT_EQ(bench.world->solver_step(), struck);
  bench.run(1000);
  EXPECT_EQ(bench.world->solver_step(), api::SolverStep{}) << "asleep";
}

double energy_j(const BodyState& body, const MassProperties& mass) {
  const Vector3d arm = body.q_WB * mass.com;
  const Vector3d v = body.v_W + body.omega_W.cross(arm);
  const Vector3d omega_B = body.q_WB.conjugate() * body.omega_W;
  return mass.mass_kg * (0.5 * v.squaredNorm() + 9.81 * (body.p_WB + arm).z()) +
         0.5 * omega_B.dot(mass.inertia * omega_B);
}

// Bodies dropped at a tilt come to rest and gain no energy.
TEST(TiltedDrop, RestsSoonAndGainsNoEnergy) {
  std::mt19937_64 engine(8);
  for (int round = 0; round < 40; ++round) {
    auto scene = empty_scene();
    add_table(scene);
    const char* type = round % 3 == 0 ? "small" : round % 3 == 1 ? "medium" : "large";
    add_gear(scene, "g", type, at({0, 0, 0.06}, any_turn(engine)));
    const MassProperties mass = gear_mass(scene.gear_types.at(type));
    Bench bench(std::move(scene));
    const int gear = bench.index_of("g");
    double gained_j = 0, before_j = energy_j(bench.world->body(gear), mass);
    for (int step = 0; step < 3000; ++step) {
      bench.run(1);
      const double now_j = energy_j(bench.world->body(gear), mass);
      gained_j += std::max(0.0, now_j - before_j);
      before_j = now_j;
    }
    const BodyState state = bench.world->body(gear);
    EXPECT_LT(state.v_W.norm(), 1e-3) << round;
    EXPECT_LT(state.omega_W.norm(), 1e-2) << round;
    EXPECT_LT(gained_j, 1e-6) << round;
  }
}

// A tray that falls onto the edge of another, whichever comes first in the scene, comes to rest on
// both ends of that edge and gains no energy as it does.
TEST(LeaningTray, RestsAndGainsNoEnergy) {
  for (const bool first : {true, false}) {
    for (const double yaw : {0.02, 0.1, 0.4}) {
      auto scene = empty_scene();
      scene.physics.simplification = scene::Simplification::kOff;
      add_table(scene);
      const auto lean = [&] {
        add_tray(scene, "leaning", "small4", {0.1, 0.01}, {}, yaw);
        Pose& X_WP = scene.trays.back().X_WP;
        X_WP.q = X_WP.q * Eigen::AngleAxisd(0.2, Vector3d::UnitY());
        X_WP.p.z() += 0.02;
      };
      if (first) lean();
      add_tray(scene, "lying", "small4", {0, 0}, {});
      if (!first) lean();
      const MassProperties mass = tray_mass(scene.tray_types.at("small4"));
      Bench bench(std::move(scene));
      double gained_j = 0, before_j = 1e9;
      for (int step = 0; step < 1500; ++step) {
        bench.run(1);
        const double now_j =
            energy_j(bench.world->body(0), mass) + energy_j(bench.world->body(1), mass);
        if (step > 100) gained_j += std::max(0.0, now_j - before_j);
        before_j = now_j;
      }
      EXPECT_LT(gained_j, 1e-8) << first << " " << yaw;
      EXPECT_LT(bench.world->body(bench.index_of("leaning")).v_W.norm(), 1e-8);
    }
  }
}

// A disc that rolls on its rim stops on the way that rolling resistance leaves it: each metre takes
// (rho / r) m g of its energy.
TEST(RollingResistance, EndsARollOnItsWay) {
  constexpr double kRho = 1e-3, kSpeed = 0.3;
  auto scene = empty_scene();
  add_table(scene);
  scene.physics.rolling_m.gear_ground = kRho;
  const scene::GearType type = scene.gear_types.at("d60");
  const double radius = type.disc_radius_m;
  add_gear(scene, "g", "d60",
           at({0, 0, radius}, Quaterniond::FromTwoVectors(Vector3d::UnitZ(), Vector3d::UnitY())));
  Bench bench(std::move(scene));
  const int gear = bench.index_of("g");
  bench.world->set_velocity(gear, {kSpeed, 0, 0}, {0, kSpeed / radius, 0});
  bench.run(4000);
  const MassProperties mass = gear_mass(type);
  const double rolling_kg = mass.mass_kg + mass.inertia(2, 2) / (radius * radius);
  const double way = 0.5 * rolling_kg * kSpeed * kSpeed * radius / (kRho * mass.mass_kg * 9.81);
  EXPECT_NEAR(bench.world->body(gear).p_WB.x(), way, 0.003 * way);
  EXPECT_LT(bench.world->body(gear).v_W.norm(), 1e-3);
}

}  // namespace
}  // namespace aprsim::physics::test
