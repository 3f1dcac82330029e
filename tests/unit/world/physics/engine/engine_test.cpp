// The interface of engines: what every engine must do alike, within its own accuracy.

#include "world/physics/engine/engine.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <thread>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/engine/engine_cases.hpp"
#include "world/physics/bodies/mass_properties.hpp"
#include "world/physics/step/make_engine.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Vector3d;

constexpr double kEngineStep_s = 1e-3, kEarth_m_s2 = 9.81, kBoxKg = 0.5;
const Vector3d kBoxSize(0.1, 0.06, 0.02), kEarth_W(0, 0, -kEarth_m_s2);

std::unique_ptr<Engine> engine_of(const EngineCase& which) {
  scene::Physics physics;
  which.apply(physics);
  return make_engine(physics);
}

RigidBody box_at(const Vector3d& p_W) {
  RigidBody body;
  body.set_mass(kBoxKg, box_inertia(kBoxKg, kBoxSize));
  body.set_position(p_W);
  return body;
}

/// A box on the plane z = 0, by its four lower corners.
class BoxOnGround {
 public:
  explicit BoxOnGround(const EngineCase& which) : engine_(engine_of(which)) {}

  void step(const Vector3d& gravity_W = kEarth_W) {
    engine_->begin({.step_s = kEngineStep_s, .gravity_W = gravity_W, .number = steps_++});
    engine_->add_body(body);
    for (std::size_t i = 0; i < 4; ++i) {
      const double x = i % 2 == 0 ? -0.5 : 0.5, y = i < 2 ? -0.5 : 0.5;
      const Vector3d corner =
          body.p_W() +
          body.R_WB() * Vector3d(x * kBoxSize.x(), y * kBoxSize.y(), -0.5 * kBoxSize.z());
      ContactConstraint& contact = contacts[i];
      contact = {};
      contact.contact = {.a = 0,
                         .b = kGround,
                         .p_W = corner,
                         .depth_m = -corner.z(),
                         .pair = SurfacePair::kGearGround};
      contact.fixed = 0;
      contact.friction = friction;
      contact.restitution = restitution;
      contact.belt = belt_speed_m_s != 0;
      const Vector3d v = body.velocity_at(corner);
      engine_->add_contact(&body, nullptr, contact,
                           {.belt_speed_m_s = belt_speed_m_s,
                            .normal_speed_m_s = v.z(),
                            .normal_accel_m_s2 = gravity_W.z()});
    }
    outcome = engine_->advance();
  }
  [[nodiscard]] Vector3d force() const {
    Vector3d sum = Vector3d::Zero();
    for (const ContactConstraint& contact : contacts) sum += contact.f_W;
    return sum;
  }

  RigidBody body = box_at({0, 0, 0.5 * kBoxSize.z()});
  std::array<ContactConstraint, 4> contacts;
  EngineOutcome outcome;
  double friction = 0.4, belt_speed_m_s = 0, restitution = 0;

 private:
  std::unique_ptr<Engine> engine_;
  std::uint64_t steps_ = 0;
};

class OnEveryEngine : public testing::TestWithParam<EngineCase> {
 protected:
  /// Relative error of a force: dWorldQuickStep ends before it is exact.
  [[nodiscard]] double accuracy() const { return GetParam().is_ode() ? 2e-2 : 1e-5; }
};

TEST_P(OnEveryEngine, ABoxAtRestCarriesItsWeight) {
  BoxOnGround slab(GetParam());
  for (int i = 0; i < 500; ++i) slab.step();
  EXPECT_TRUE(slab.outcome.converged);
  EXPECT_NEAR(slab.force().z(), kBoxKg * kEarth_m_s2, accuracy() * kBoxKg * kEarth_m_s2);
  double normal_n = 0;
  for (const ContactConstraint& contact : slab.contacts) normal_n += contact.normal_n;
  EXPECT_NEAR(normal_n, slab.force().z(), 1e-9);
  EXPECT_LT(slab.body.v_W().norm(), 1e-4);
  EXPECT_NEAR(slab.body.p_W().z(), 0.5 * kBoxSize.z(), 1e-4);
}

// Not along an axis of the world: a pyramid with fixed edges would have 1.34 times the friction.
TEST_P(OnEveryEngine, ABoxSlidesByCoulombsLaw) {
  BoxOnGround slab(GetParam());
  for (int i = 0; i < 100; ++i) slab.step();
  const Vector3d start = Vector3d(1, 2, 0).normalized();
  slab.body.set_velocity(start, Vector3d::Zero());
  constexpr int kSteps = 200;
  for (int i = 0; i < kSteps; ++i) slab.step();
  const double expected = 1 - slab.friction * kEarth_m_s2 * kSteps * kEngineStep_s;
  EXPECT_NEAR(slab.body.v_W().dot(start), expected, GetParam().is_ode() ? 0.01 : 1e-5);
  EXPECT_NEAR(slab.force().head<2>().norm(), slab.friction * slab.force().z(),
              accuracy() * kBoxKg * kEarth_m_s2);
}

TEST_P(OnEveryEngine, FrictionHoldsABoxBelowItsLimitOnly) {
  for (const double slope : {0.9, 1.1}) {
    BoxOnGround slab(GetParam());
    for (int i = 0; i < 100; ++i) slab.step();
    const double across = slope * slab.friction * kEarth_m_s2;
    for (int i = 0; i < 200; ++i) slab.step({across, 0, -kEarth_m_s2});
    const double free = (across - slab.friction * kEarth_m_s2) * 200 * kEngineStep_s;
    EXPECT_NEAR(slab.body.v_W().x(), std::max(0.0, free), 0.1 * std::abs(free)) << slope;
  }
}

TEST_P(OnEveryEngine, ABeltCarriesABox) {
  BoxOnGround slab(GetParam());
  slab.belt_speed_m_s = 0.3;
  for (int i = 0; i < 300; ++i) slab.step();
  EXPECT_NEAR(slab.body.v_W().x(), 0.3, 1e-3);
  EXPECT_NEAR(slab.body.v_W().y(), 0, 1e-3);
}

TEST_P(OnEveryEngine, AnImpactGivesItsShareBack) {
  BoxOnGround slab(GetParam());
  slab.restitution = 0.5;
  slab.body.set_position({0, 0, 0.5 * kBoxSize.z() + 2e-3});
  slab.body.set_velocity({0, 0, -1}, Vector3d::Zero());
  double fastest = 0;
  for (int i = 0; i < 10; ++i) {
    slab.step(Vector3d::Zero());
    fastest = std::max(fastest, slab.body.v_W().z());
  }
  EXPECT_NEAR(fastest, 0.5, 0.02);
}

TEST_P(OnEveryEngine, AGapClosesWithoutAnImpactBefore) {
  BoxOnGround slab(GetParam());
  slab.body.set_position({0, 0, 0.5 * kBoxSize.z() + 1.5e-3});
  slab.body.set_velocity({0, 0, -1}, Vector3d::Zero());
  slab.step(Vector3d::Zero());
  EXPECT_NEAR(slab.body.p_W().z(), 0.5 * kBoxSize.z() + 0.5e-3, 1e-6);
  slab.step(Vector3d::Zero());
  EXPECT_NEAR(slab.body.p_W().z(), 0.5 * kBoxSize.z(), 1e-4);
}

// ---- joints

/// A body in a joint to a kinematic one, under gravity.
struct JoinedBox {
  explicit JoinedBox(const EngineCase& which) : engine(engine_of(which)) {}
  template <typename AddJoints>
  void step(const AddJoints& add_joints) {
    engine->begin({.step_s = kEngineStep_s, .gravity_W = kEarth_W, .number = steps++});
    engine->add_body(body);
    add_joints();
    static_cast<void>(engine->advance());
  }

  std::unique_ptr<Engine> engine;
  RigidBody body = box_at({0.3, 0, 1}), base = box_at({0, 0, 1});
  std::uint64_t steps = 0;
};

TEST_P(OnEveryEngine, AFixedJointHoldsAndTellsItsForce) {
  JoinedBox joined(GetParam());
  std::array<JointForce, 6> forces{};
  constexpr int kSteps = 300, kMeasured = 100;
  double force_n = 0, torque_nm = 0;  // means of the last steps
  for (int i = 0; i < kSteps; ++i) {
    joined.step([&] {
      joined.engine->add_joint(
          FixedJoint{.a = joined.body,
                     .b = joined.base,
                     .X_WA = Eigen::Isometry3d(Eigen::Translation3d(0.3, 0, 1)),
                     .X_WB = Eigen::Isometry3d(Eigen::Translation3d(0, 0, 1)),
                     .lever_W = joined.base.p_W() - joined.body.p_W(),
                     .compliance = 1e-8,
                     .forces = forces});
    });
    if (i < kSteps - kMeasured) continue;
    force_n += forces[2].last_n() / kMeasured;
    torque_nm += forces[4].last_n() / kMeasured;
  }
  const double weight_n = kBoxKg * kEarth_m_s2;
  EXPECT_NEAR(force_n, weight_n, accuracy() * weight_n);
  // At the centre of mass of the base: the weight of the body at its lever.
  EXPECT_NEAR(torque_nm, -0.3 * weight_n, accuracy() * 0.3 * weight_n);
  EXPECT_LT((joined.body.p_W() - Vector3d(0.3, 0, 1)).norm(), 1e-4);
}

TEST_P(OnEveryEngine, ASpringOfAFixedJointGivesWayAsComputed) {
  JoinedBox joined(GetParam());
  joined.body.set_position(joined.base.p_W());
  std::array<JointForce, 6> forces{};
  constexpr double kStiffness = 2000, kDamping = 100;
  const double hk = kEngineStep_s * kStiffness;
  for (int i = 0; i < 1000; ++i) {
    joined.step([&] {
      joined.engine->add_joint(
          FixedJoint{.a = joined.body,
                     .b = joined.base,
                     .spring = FixedJoint::Spring{hk / (hk + kDamping), 1 / (hk + kDamping)},
                     .compliance = 1e-9,
                     .forces = forces});
    });
  }
  const double sag = kBoxKg * kEarth_m_s2 / kStiffness;
  EXPECT_NEAR(joined.base.p_W().z() - joined.body.p_W().z(), sag, 0.02 * sag);
}

/// Slides along z of the world: the axes are turned.
class SlidingBox {
 public:
  explicit SlidingBox(const EngineCase& which) : joined_(which) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitX()));
    for (RigidBody* body : {&joined_.body, &joined_.base}) body->set_orientation(turn);
    joined_.body.set_position(joined_.base.p_W() + joined_.base.R_WB() * kFrom);
  }
  void step(double speed_m_s, double force_n) {
    joined_.step([&] {
      joined_.engine->add_joint(SliderJoint{.a = joined_.body,
                                            .b = joined_.base,
                                            .p_BA = kFrom,
                                            .sign = 1,
                                            .travel_m = travel_m(),
                                            .end_m = kEnd,
                                            .speed_m_s = speed_m_s,
                                            .force_n = force_n,
                                            .rail = rail_,
                                            .motor = motor_,
                                            .lower_stop = lower_,
                                            .upper_stop = upper_});
    });
  }
  [[nodiscard]] double travel_m() const {
    return joined_.body.p_W().z() - joined_.base.p_W().z() - (joined_.base.R_WB() * kFrom).z();
  }
  [[nodiscard]] double across_m() const {
    return (joined_.body.p_W() - joined_.base.p_W() - joined_.base.R_WB() * kFrom).head<2>().norm();
  }
  [[nodiscard]] double speed_m_s() const { return joined_.body.v_W().z(); }

  static constexpr double kEnd = 0.02;

 private:
  inline static const Vector3d kFrom{0.05, 0, 0.02};
  JoinedBox joined_;
  std::array<JointForce, 5> rail_{};
  JointForce motor_, lower_, upper_;
};

TEST_P(OnEveryEngine, ASliderMovesAsFarAsItsMotorAndStopsLetIt) {
  SlidingBox slide(GetParam());
  const double weight = kBoxKg * kEarth_m_s2;
  for (int i = 0; i < 100; ++i) slide.step(0.1, 2 * weight);
  EXPECT_NEAR(slide.speed_m_s(), 0.1, 2e-3);
  EXPECT_NEAR(slide.travel_m(), 0.01, 5e-4);
  for (int i = 0; i < 300; ++i) slide.step(0.1, 2 * weight);
  EXPECT_NEAR(slide.travel_m(), SlidingBox::kEnd, 1e-4);
  // Too weak a motor gives way to the weight, down to the lower stop.
  for (int i = 0; i < 500; ++i) slide.step(0.1, 0.5 * weight);
  EXPECT_NEAR(slide.travel_m(), 0, 1e-4);
  EXPECT_LT(slide.across_m(), 1e-4);
}

// A pendulum of a hinge swings with its period; a rod to its far end can hold it.
TEST_P(OnEveryEngine, AHingeTurnsUntilARodHoldsIt) {
  JoinedBox joined(GetParam());
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitX()));
  for (RigidBody* body : {&joined.body, &joined.base}) body->set_orientation(turn);
  joined.body.set_position(joined.base.p_W() + Vector3d(0.1, 0, 0));
  std::array<JointForce, 5> forces{};
  JointForce in_rod;
  const Vector3d load(0, 0, -2);
  const auto step = [&](bool rod) {
    joined.body.add_force_at(load, joined.body.p_W() + joined.body.R_WB() * Vector3d(0.05, 0, 0));
    joined.step([&] {
      joined.engine->add_joint(
          HingeJoint{.a = joined.body, .b = joined.base, .p_BA = {0.1, 0, 0}, .forces = forces});
      if (!rod) return;
      joined.engine->add_joint(RodJoint{.a = joined.body,
                                        .b = joined.base,
                                        .p_A = {0.05, 0, 0},
                                        .p_B = {0.15, 0.1, 0},
                                        .length_m = 0.1,
                                        .force = in_rod});
    });
  };
  for (int i = 0; i < 300; ++i) step(true);
  const Vector3d end = joined.body.p_W() + joined.body.R_WB() * Vector3d(0.05, 0, 0);
  EXPECT_LT((end - joined.base.p_W() - Vector3d(0.15, 0, 0)).norm(), 5e-4);
  for (int i = 0; i < 50; ++i) step(false);
  EXPECT_LT((joined.body.p_W() - joined.base.p_W() - Vector3d(0.1, 0, 0)).norm(), 5e-4);
  // The torque of the load about the hinge.
  const double accel = 2 * 0.05 / joined.body.inertia_B()(2, 2);
  EXPECT_NEAR(joined.body.omega_W().norm(), accel * 50 * kEngineStep_s,
              0.1 * accel * 50 * kEngineStep_s);
}

// ---- bits

std::vector<double> box_course(const EngineCase& which, int slabs) {
  std::vector<double> out;
  for (int k = 0; k < slabs; ++k) {
    BoxOnGround slab(which);
    slab.body.set_velocity({0.3, 0.1 * k, 0}, {0, 0, 2});
    for (int i = 0; i < 200; ++i) slab.step();
    for (const double value : {slab.body.p_W().x(), slab.body.p_W().y(), slab.body.omega_W().z()}) {
      out.push_back(value);
    }
  }
  return out;
}

TEST_P(OnEveryEngine, TheSameCallsGiveTheSameBits) {
  EXPECT_EQ(box_course(GetParam(), 2), box_course(GetParam(), 2));
}

TEST_P(OnEveryEngine, EnginesInOtherThreadsChangeNoBits) {
  const std::vector<double> alone = box_course(GetParam(), 20);
  std::array<std::vector<double>, 3> beside;
  {
    std::vector<std::jthread> threads;
    for (auto& of_thread : beside) {
      threads.emplace_back([&of_thread] { of_thread = box_course(GetParam(), 20); });
    }
  }
  for (const auto& of_thread : beside) EXPECT_EQ(of_thread, alone);
}

// A load that is not a number must not reach the other body of the solve, nor the next solve.
TEST(OdeEngine, AFailureIsToldAndReachesNoOtherBody) {
  for (const EngineCase& which : kEngines) {
    if (!which.is_ode()) continue;
    SCOPED_TRACE(which.name);
    const auto engine = engine_of(which);
    RigidBody bad = box_at({0, 0, 1}), good = box_at({0, 0, 1.02});
    ContactConstraint contact;
    contact.contact = {.a = 1, .b = 0, .p_W = {0, 0, 1.01}, .depth_m = 1e-5};
    contact.friction = 0.5;
    const auto step = [&] {
      engine->begin({.step_s = kEngineStep_s, .gravity_W = kEarth_W});
      engine->add_body(bad);
      engine->add_body(good);
      engine->add_contact(&good, &bad, contact, {});
      return engine->advance().converged;
    };
    bad.add_load({std::numeric_limits<double>::quiet_NaN(), 0, 0}, Vector3d::Zero());
    EXPECT_FALSE(step());
    EXPECT_NEAR(good.v_W().z(), -kEarth_m_s2 * kEngineStep_s, 1e-12);
    EXPECT_TRUE(step());
    EXPECT_TRUE(good.p_W().allFinite() && bad.p_W().allFinite());
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, OnEveryEngine, testing::ValuesIn(kEngines),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace aprsim::physics::test
