// A merged or dormant group is indistinguishable to those who look.

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

using scene::Simplification;

scene::Scene loaded_belt(Simplification mode) {
  auto scene = empty_scene();
  scene.physics.simplification = mode;
  add_belt(scene);
  add_tray(scene, "a", "small4", {-1.0, 0.1}, {"s1=a1", "s2=a2", "s3=a3", "s4=a4"}, 0.2);
  add_tray(scene, "b", "medium4", {-0.7, -0.1}, {"s1=b1", "s4=b4"}, -0.4);
  return scene;
}

class Observers : public testing::TestWithParam<Simplification> {};

// A run of the belt with start, change of direction and stop: poses, velocities, contacts and what
// is called resting are those of contacts solved in full.
TEST_P(Observers, SeeTheSameOverARunOfTheBelt) {
  Bench full(loaded_belt(Simplification::kOff));
  Bench bench(loaded_belt(GetParam()));
  double speed = 0;
  for (int step = 0; step < 2600; ++step) {
    const double wanted = step < 300 ? 0 : step < 1300 ? 0.2 : step < 2000 ? -0.1 : 0;
    speed += std::clamp(wanted - speed, -5e-4, 5e-4);
    for (Bench* each : {&full, &bench}) {
      each->world->set_belt_speed(speed);
      each->run(1);
    }
    if (step < 100) continue;  // settling
    ASSERT_EQ(bench.world->contact_count(), full.world->contact_count()) << step;
    for (int i = 0; i < full.world->body_count(); ++i) {
      const BodyState one = full.world->body(i), other = bench.world->body(i);
      ASSERT_LT((one.p_WB - other.p_WB).norm(), 1e-6) << "body " << i << " at step " << step;
      ASSERT_LT(one.q_WB.angularDistance(other.q_WB), 5e-5) << "body " << i << " at " << step;
      ASSERT_LT((one.v_W - other.v_W).norm(), 1e-5) << "body " << i << " at step " << step;
      ASSERT_EQ(one.resting, other.resting) << "body " << i << " at step " << step;
    }
  }
}

std::vector<api::ContactSnapshot> contacts_of(const Bench& bench) {
  std::vector<api::ContactSnapshot> contacts;
  bench.world->write_contacts(contacts);
  return contacts;
}

bool is(const api::ContactSide& side, api::ContactSide::Kind kind, int index) {
  return side.kind == kind && side.index == index;
}

// A gear in its tray on a table: every force is reported where it acts, on whom and by whom.
TEST(Contacts, BearTheWeightOfWhatRests) {
  using Kind = api::ContactSide::Kind;
  auto scene = empty_scene();
  scene.physics.simplification = Simplification::kOff;
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=gear"});
  const double gear_kg = scene.gear_types.at("small").mass_kg;
  const double tray_kg = scene.tray_types.at("small4").mass_kg;
  Bench bench(std::move(scene));
  bench.run(500);
  const auto names = bench.world->fixed_names();
  Eigen::Vector3d on_gear = Eigen::Vector3d::Zero(), on_tray = on_gear;
  const auto contacts = contacts_of(bench);
  ASSERT_EQ(static_cast<int>(contacts.size()), bench.world->contact_count());
  for (const auto& contact : contacts) {
    if (is(contact.first, Kind::kBody, 1) && is(contact.second, Kind::kBody, 0)) {
      on_gear += contact.f_W;
      on_tray -= contact.f_W;
      EXPECT_LT((contact.p_W - bench.X_WB("gear").translation()).norm(), 0.05);
    } else {
      ASSERT_TRUE(is(contact.first, Kind::kBody, 0));
      ASSERT_EQ(contact.second.kind, Kind::kFixed);
      EXPECT_EQ(names.at(static_cast<std::size_t>(contact.second.index)), "table");
      on_tray += contact.f_W;
    }
  }
  EXPECT_NEAR(on_gear.z(), gear_kg * 9.81, 1e-3);
  EXPECT_NEAR(on_tray.z(), tray_kg * 9.81, 1e-3);
  EXPECT_LT(on_gear.head<2>().norm() + on_tray.head<2>().norm(), 1e-3);
}

// What sleeps has no forces, and what a gripper holds has those of its pads.
TEST(Contacts, OfAGripAreThoseOfThePads) {
  using Kind = api::ContactSide::Kind;
  auto scene = empty_scene();
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=gear"});
  const Eigen::Vector3d peg = scene.gears[0].X_WP.p + Eigen::Vector3d(0, 0, 0.010);
  add_hand(scene, peg + Eigen::Vector3d(0, 0, 0.05));
  Bench bench(std::move(scene));
  bench.run(300);
  EXPECT_TRUE(contacts_of(bench).empty()) << "dormant";
  bench.move({0, 0, -0.05}, 0.5);
  bench.grip(0);
  double pressing = 0;
  for (const auto& contact : contacts_of(bench)) {
    if (is(contact.first, Kind::kRobot, 0) && is(contact.second, Kind::kBody, 1)) {
      pressing += std::abs(contact.f_W.y());  // along the fingers' way, whatever the pads' faces
    }
  }
  const auto& force = bench.world->gripper(0).force_n;
  EXPECT_GT(force[0], 10);
  EXPECT_NEAR(pressing, force[0] + force[1], 1e-3 * pressing);
}

INSTANTIATE_TEST_SUITE_P(Simplification, Observers,
                         testing::Values(Simplification::kMerge, Simplification::kDormant));

}  // namespace
}  // namespace aprsim::physics::test
