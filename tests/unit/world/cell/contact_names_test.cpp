#include "world/api/snapshot/contact_names.hpp"

#include <gtest/gtest.h>

namespace aprsim::api {
namespace {

using Kind = ContactSide::Kind;

TEST(ContactNames, TellThingsOfOneNameApart) {
  CellDescription cell;
  cell.bodies.resize(3);
  cell.bodies[0] = {.name = "post", .kind = BodyKind::kPartTray};
  cell.bodies[1] = {.name = "gear", .kind = BodyKind::kGear};
  cell.bodies[2] = {.name = "arm", .kind = BodyKind::kGear};
  cell.robots.resize(2);
  cell.robots[0].name = "arm";
  cell.robots[1].name = "other";
  cell.fixed = {"post", "table"};
  EXPECT_EQ(contact_name(cell, {Kind::kBody, 1}), "gear");
  EXPECT_EQ(contact_name(cell, {Kind::kRobot, 1}), "other");
  EXPECT_EQ(contact_name(cell, {Kind::kFixed, 1}), "table");
  EXPECT_EQ(contact_name(cell, {Kind::kBody, 0}), "tray post");
  EXPECT_EQ(contact_name(cell, {Kind::kFixed, 0}), "fixed post");
  EXPECT_EQ(contact_name(cell, {Kind::kBody, 2}), "gear arm");
  EXPECT_EQ(contact_name(cell, {Kind::kRobot, 0}), "robot arm");
}

TEST(ContactNames, TellARobotsParts) {
  RobotDescription robot;
  robot.links = {"base", "link_1"};
  EXPECT_EQ(part_name(robot, -1), "");
  EXPECT_EQ(part_name(robot, 0), "palm");
  EXPECT_EQ(part_name(robot, 1), "finger_1");
  EXPECT_EQ(part_name(robot, 2), "finger_2");
  EXPECT_EQ(part_name(robot, ContactSide::kFirstLink), "base");
  EXPECT_EQ(part_name(robot, ContactSide::kFirstLink + 1), "link_1");
  EXPECT_EQ(part_name(robot, ContactSide::kFirstLink + 2), "");
}

}  // namespace
}  // namespace aprsim::api
