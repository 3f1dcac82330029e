// Contacts of robots that belong to no work, recorded from step to step.

#include "world/cell/observation/unintended_contacts.hpp"

#include <array>
#include <map>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"

namespace aprsim::test {
namespace {

using Side = api::ContactSide;

constexpr Side kTable{Side::Kind::kFixed, 2};

/// Two robots with a gear and a tray.
class UnintendedContactsTest : public testing::Test {
 protected:
  UnintendedContactsTest() {
    bodies_[0].kind = api::BodyKind::kGear;
    bodies_[1].kind = api::BodyKind::kKitTray;
  }

  static physics::ArmForce on_link(const Side& partner, double force_n) {
    return {.link = 4, .f_W = {0, 0, force_n}, .partner = partner};
  }
  static physics::ArmForce on_finger(const Side& partner, double force_n) {
    return {.link = 5, .f_W = {force_n, 0, 0}, .partner = partner, .on_gripper = true, .part = 1};
  }
  void add(std::uint64_t step, std::vector<physics::ArmForce> forces, int robot = 0,
           bool has_tool = true) {
    touches_.add(step, robot, forces, has_tool, bodies_);
  }
  [[nodiscard]] std::size_t count() const { return touches_.list() ? touches_.list()->size() : 0; }

  std::array<scene::FreeBody, 2> bodies_;
  world::UnintendedContacts touches_;
};

TEST_F(UnintendedContactsTest, KeepTheGreatestSumOfForces) {
  add(7, {on_link(kTable, 3), on_link(kTable, 4), on_finger(kTable, 1)});
  add(8, {on_link(kTable, 5)});
  ASSERT_EQ(count(), 2U);
  const api::UnintendedContact& touch = touches_.list()->at(0);
  EXPECT_EQ(touch.first, (Side{Side::Kind::kRobot, 0, Side::kFirstLink + 4}));
  EXPECT_EQ(touch.second, kTable);
  EXPECT_EQ(touch.begin_step, 7U);
  EXPECT_EQ(touch.last_step, 8U);
  EXPECT_EQ(touch.max_force_n, 7);
  EXPECT_EQ(touches_.list()->at(1).first, (Side{Side::Kind::kRobot, 0, 1}));
}

TEST_F(UnintendedContactsTest, AreSeparateAfterAPause) {
  add(1, {on_link(kTable, 3)});
  add(251, {on_link(kTable, 4)});
  EXPECT_EQ(count(), 1U);
  add(502, {on_link(kTable, 5)});
  ASSERT_EQ(count(), 2U);
  EXPECT_EQ(touches_.list()->at(1).begin_step, 502U);
}

TEST_F(UnintendedContactsTest, ExcludeWork) {
  const Side gear{Side::Kind::kBody, 0}, tray{Side::Kind::kBody, 1};
  physics::ArmForce relayed = on_finger(kTable, 5);
  relayed.relayed = true;
  physics::ArmForce drawn = on_finger(tray, 5);
  drawn.part = -1;
  add(1, {on_finger(gear, 5), relayed, drawn, on_link(kTable, 0)});
  add(1, {on_finger(kTable, 5)}, 0, false);
  EXPECT_EQ(count(), 0U);
  add(1, {on_finger(tray, 5), on_link(gear, 5)});
  EXPECT_EQ(count(), 2U);
}

TEST_F(UnintendedContactsTest, CountOnceForTwoArms) {
  const Side first{Side::Kind::kRobot, 0, Side::kFirstLink + 1},
      second{Side::Kind::kRobot, 1, Side::kFirstLink + 2};
  add(1, {on_link(second, 5)}, 0);
  add(1, {on_link(first, 5)}, 1);
  ASSERT_EQ(count(), 1U);
  EXPECT_EQ(touches_.list()->at(0).second, second);
}

TEST_F(UnintendedContactsTest, DropTheOldest) {
  for (int i = 0; i < 100; ++i) add(static_cast<std::uint64_t>(1000 * i), {on_link(kTable, 3)});
  ASSERT_EQ(count(), api::kMaxUnintendedContacts);
  EXPECT_EQ(touches_.list()->at(0).begin_step, 36000U);
}

// A gear falls on an arm: the contacts of every step tell the same.
TEST(UnintendedContacts, MissNoStep) {
  auto scene = *load_scene("aprs");
  CellScript still(std::make_shared<const scene::Scene>(scene));
  still.advance(1);
  const Eigen::Vector3d above = still.now.robots[0].X_WT.p + Eigen::Vector3d(0, 0, 0.6);
  scene.gears.push_back({"falling", scene.gears[0].type, Pose{.p = above}});
  CellScript cell(std::make_shared<const scene::Scene>(std::move(scene)));
  const auto falling = static_cast<int>(cell.body("falling"));
  std::map<int, double> max_force_n;  // by part of the robot
  for (int step = 0; step < 700; ++step) {
    cell.advance(1);
    std::map<int, double> sums_n;
    for (const auto& contact : cell.now.contacts) {
      if (contact.first != Side{Side::Kind::kBody, falling}) continue;
      if (contact.second.kind != Side::Kind::kRobot) continue;
      sums_n[contact.second.part] += contact.f_W.norm();
    }
    for (const auto& [part, sum_n] : sums_n) {
      max_force_n[part] = std::max(max_force_n[part], sum_n);
    }
  }
  std::erase_if(max_force_n, [](const auto& entry) { return entry.second <= 0; });
  ASSERT_FALSE(max_force_n.empty());
  ASSERT_NE(cell.now.unintended_contacts, nullptr);
  std::map<int, double> told_n;
  for (const api::UnintendedContact& touch : *cell.now.unintended_contacts) {
    EXPECT_EQ(touch.second, (Side{Side::Kind::kBody, falling}));
    told_n[touch.first.part] = std::max(told_n[touch.first.part], touch.max_force_n);
  }
  ASSERT_EQ(told_n.size(), max_force_n.size());
  for (const auto& [part, force_n] : max_force_n) EXPECT_NEAR(told_n[part], force_n, 1e-9) << part;
}

}  // namespace
}  // namespace aprsim::test
