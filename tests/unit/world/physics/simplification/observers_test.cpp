// A merged or dormant group is indistinguishable to those who look.

#include <cmath>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/parameter_names.hpp"
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

/// Every bit of what observers see of the bodies.
void expect_same_bits(const Bench& one, const Bench& other) {
  for (int i = 0; i < one.world->body_count(); ++i) {
    const BodyState a = one.world->body(i), b = other.world->body(i);
    EXPECT_EQ(a.p_WB, b.p_WB) << "body " << i;
    EXPECT_EQ(a.q_WB.coeffs(), b.q_WB.coeffs()) << "body " << i;
    EXPECT_EQ(a.v_W, b.v_W) << "body " << i;
    EXPECT_EQ(a.omega_W, b.omega_W) << "body " << i;
    EXPECT_EQ(a.resting, b.resting) << "body " << i;
    EXPECT_EQ(a.group, b.group) << "body " << i;
  }
}

// Poses of what sleeps are worked out when they are asked for. That changes nothing, and gives the
// same bits in a world that went on from a saved state, asleep, struck and woken, and asleep again.
TEST_P(Observers, ChangeNothingAndSeeTheSameBitsInARestoredWorld) {
  Bench seen(loaded_belt(GetParam())), unseen(loaded_belt(GetParam()));
  PhysicsWorld::State saved;
  for (int step = 0; step < 1600; ++step) {
    for (Bench* each : {&seen, &unseen}) {
      each->world->set_belt_speed(step < 300 ? 0 : std::min(0.2, 5e-4 * (step - 300)));
      if (step == 900) each->world->set_velocity(each->index_of("a2"), {0, 0, 0.2}, {0, 0, 1});
      each->run(1);
    }
    for (int i = 0; i < seen.world->body_count(); ++i) {
      ASSERT_TRUE(seen.world->body(i).p_WB.allFinite());
    }
    if (step == 500) saved = unseen.world->save();
  }
  EXPECT_EQ(seen.world->state_hash(), unseen.world->state_hash());
  expect_same_bits(seen, unseen);
  Bench again(loaded_belt(GetParam()));
  again.world->restore(saved);
  unseen.world->restore(saved);
  expect_same_bits(again, unseen);
  for (Bench* each : {&again, &unseen}) {
    each->world->set_belt_speed(0.2);
    each->run(300);
  }
  expect_same_bits(again, unseen);
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

/// Contacts of one pair of things, summed up.
struct PairContact {
  int points = 0;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
};

std::map<std::string, PairContact> by_pair(const Bench& bench) {
  std::map<std::string, PairContact> pairs;
  for (const auto& contact : contacts_of(bench)) {
    const auto side = [&](const api::ContactSide& which) {
      return std::to_string(static_cast<int>(which.kind)) + ' ' + std::to_string(which.index);
    };
    PairContact& pair = pairs[side(contact.first) + " on " + side(contact.second)];
    ++pair.points;
    pair.force += contact.f_W;
  }
  return pairs;
}

/// The same partners at the same points with the same forces, in the same order.
void expect_same_contacts(const Bench& one, const Bench& other, const std::string& when) {
  const auto full = contacts_of(one), simplified = contacts_of(other);
  ASSERT_GT(full.size(), 20u) << when;
  ASSERT_EQ(full.size(), simplified.size()) << when;
  for (std::size_t i = 0; i < full.size(); ++i) {
    const auto same = [](const api::ContactSide& a, const api::ContactSide& b) {
      return a.kind == b.kind && a.index == b.index && a.part == b.part;
    };
    ASSERT_TRUE(same(full[i].first, simplified[i].first)) << when << ' ' << i;
    ASSERT_TRUE(same(full[i].second, simplified[i].second)) << when << ' ' << i;
    ASSERT_LT((full[i].p_W - simplified[i].p_W).norm(), 1e-5) << when << ' ' << i;
  }
  const auto full_pairs = by_pair(one), pairs = by_pair(other);
  for (const auto& [name, pair] : full_pairs) {
    ASSERT_TRUE(pairs.contains(name)) << when << ' ' << name;
    EXPECT_EQ(pairs.at(name).points, pair.points) << when << ' ' << name;
    EXPECT_LT((pairs.at(name).force - pair.force).norm(), 0.02 * pair.force.norm() + 2e-3)
        << when << ' ' << name;
  }
}

// Frozen contacts are reported as they were: the list is the same in every mode, at rest, on the
// running belt, and after restoring a saved state.
TEST_P(Observers, ListTheSameContacts) {
  Bench full(loaded_belt(Simplification::kOff)), bench(loaded_belt(GetParam()));
  const auto run = [&](int steps, double speed) {
    for (Bench* each : {&full, &bench}) {
      each->world->set_belt_speed(speed);
      each->run(steps);
    }
  };
  run(400, 0);
  expect_same_contacts(full, bench, "at rest");
  const auto saved = bench.world->save();
  const auto before = contacts_of(bench);
  for (int i = 1; i <= 400; ++i) run(1, 5e-4 * i);
  run(300, 0.2);
  expect_same_contacts(full, bench, "on the running belt");
  Bench fresh(loaded_belt(GetParam()));
  for (Bench* each : {&bench, &fresh}) {
    each->world->restore(saved);
    const auto after = contacts_of(*each);
    ASSERT_EQ(after.size(), before.size());
    for (std::size_t i = 0; i < after.size(); ++i) {
      EXPECT_EQ(after[i].p_W, before[i].p_W);
      EXPECT_EQ(after[i].f_W, before[i].f_W);
    }
  }
}

// A hit body leaves its group: no contact is reported twice, and none of the old ones remains.
TEST_P(Observers, DropTheContactsOfAHitBody) {
  Bench bench(loaded_belt(GetParam()));
  bench.run(400);
  const std::size_t before = contacts_of(bench).size();
  const int gear = bench.index_of("a2");
  bench.world->set_velocity(gear, {0, 0, 1}, {0, 0, 0});
  bench.run(60);  // in the air
  for (const auto& contact : contacts_of(bench)) {
    EXPECT_FALSE(is(contact.first, api::ContactSide::Kind::kBody, gear));
    EXPECT_FALSE(is(contact.second, api::ContactSide::Kind::kBody, gear));
  }
  EXPECT_LT(contacts_of(bench).size(), before);
  bench.run(1500);
  EXPECT_EQ(static_cast<int>(contacts_of(bench).size()), bench.world->contact_count());
}

// A held body has the contacts of the pads.
TEST(Contacts, OfAGripAreThoseOfThePads) {
  using Kind = api::ContactSide::Kind;
  auto scene = empty_scene();
  add_table(scene);
  add_tray(scene, "tray", "small4", {0, 0}, {"s1=gear"});
  const Eigen::Vector3d peg = scene.gears[0].X_WP.p + Eigen::Vector3d(0, 0, 0.010);
  add_hand(scene, peg + Eigen::Vector3d(0, 0, 0.05));
  Bench bench(std::move(scene));
  bench.run(300);
  EXPECT_EQ(bench.world->body(1).group_kind, api::GroupKind::kDormant);
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
