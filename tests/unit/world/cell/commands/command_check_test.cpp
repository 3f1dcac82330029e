#include "world/cell/commands/command_check.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

api::CellDescription cell() {
  api::CellDescription out;
  out.scene = "test";
  out.robots.resize(1);
  out.robots[0].name = "fanuc";
  out.robots[0].joints.resize(6);
  return out;
}

Result<void> checked(api::Command command) {
  return check(command, std::make_shared<const api::CellDescription>(cell()));
}

std::string error_of(api::RobotAction action, int robot = 0) {
  const auto ok = checked({.endpoint = 0, .body = api::RobotCommand{robot, std::move(action)}});
  return ok ? "" : ok.error().message;
}

std::string error_of_stream(api::TrajectoryAction action, int robot = 0) {
  const auto ok =
      checked({.endpoint = 0, .body = api::TrajectoryCommand{robot, std::move(action)}});
  return ok ? "" : ok.error().message;
}

TEST(CommandCheck, RefusesStreamsThatMakeNoSense) {
  EXPECT_EQ(error_of_stream(api::ClaimMotion{"driver"}), "");
  EXPECT_EQ(error_of_stream(api::ClaimMotion{"driver"}, 1),
            "robot 1 does not exist; the cell has 1");
  EXPECT_EQ(error_of_stream(api::ClaimMotion{""}),
            "a name of 0 bytes, must be UTF-8 text of 1 to 128");
  EXPECT_EQ(error_of_stream(api::ClaimMotion{std::string(129, 'a')}),
            "a name of 129 bytes, must be UTF-8 text of 1 to 128");
  EXPECT_NE(error_of_stream(api::ClaimMotion{"\xff"}), "");
  for (std::vector<double> api::TrajectoryPoint::*field :
       {&api::TrajectoryPoint::position_rad, &api::TrajectoryPoint::velocity_rad_s,
        &api::TrajectoryPoint::acceleration_rad_s2}) {
    api::TrajectoryPoint point;
    point.*field = {0, kNan};
    EXPECT_NE(error_of_stream(api::AppendPoints{1, true, {point}}).find("not a finite number"),
              std::string::npos);
    EXPECT_NE(error_of_stream(api::FollowTrajectory{.commander = "a", .points = {point}}), "");
  }
  const std::vector<api::TrajectoryPoint> many(api::kMaxTrajectoryPoints + 1);
  EXPECT_EQ(error_of_stream(api::AppendPoints{1, true, many}),
            "there are 4001 points, the limit is 4000");
  EXPECT_EQ(error_of_stream(api::AppendMove{1, {0}, 0.2, 0.5}), "");
  EXPECT_NE(error_of_stream(api::AppendMove{1, {kNan}}), "");
  EXPECT_NE(error_of_stream(api::AppendMove{1, {0}, 0}), "");
  EXPECT_NE(error_of_stream(api::AppendMove{1, {0}, 1.1}), "");
  EXPECT_NE(error_of_stream(api::AppendMove{1, {0}, 1, -0.1}), "");
  EXPECT_NE(error_of_stream(api::AppendMove{1, {0}, 1, kNan}), "");
  EXPECT_EQ(error_of_stream(api::AppendMove{1, {0}, 1, 0, 17}), "17 moves, must be 1 to 16");
  const auto goal = [](auto change) {
    api::FollowTrajectory out{.commander = "a"};
    change(out);
    return error_of_stream(out);
  };
  EXPECT_EQ(goal([](auto& g) { g.goal_time_tolerance = std::chrono::seconds(1); }), "");
  EXPECT_NE(goal([](auto& g) { g.goal_time_tolerance = std::chrono::seconds(-1); }), "");
  EXPECT_NE(goal([](auto& g) { g.path_tolerance = {{-1, 0}}; }), "");
  EXPECT_NE(goal([](auto& g) { g.goal_tolerance = {{0, kNan}}; }), "");
  EXPECT_NE(goal([](auto& g) { g.goal_tolerance.resize(8); }), "");
  EXPECT_NE(goal([](auto& g) { g.joint_names.assign(8, "a"); }), "");
  EXPECT_NE(goal([](auto& g) { g.joint_names = {"\xff"}; }), "");
}

TEST(CommandCheck, RefusesWhatIsNotThere) {
  EXPECT_EQ(error_of(api::InitRobot{}), "");
  EXPECT_EQ(error_of(api::InitRobot{}, 1), "robot 1 does not exist; the cell has 1");
  EXPECT_EQ(error_of(api::MoveJoints{{{.joint = 6}}}),
            "joint 7 does not exist; fanuc has joints 1 to 6");
  EXPECT_EQ(error_of(api::MoveJoints{{{.joint = -1}}}),
            "joint 0 does not exist; fanuc has joints 1 to 6");
  EXPECT_EQ(error_of(api::MoveJoints{}), "no joint is named");
  EXPECT_EQ(error_of(api::MoveThroughTo{}), "no waypoint is given");
  const auto belt = checked({.endpoint = 0, .body = api::ConveyorCommand{}});
  ASSERT_FALSE(belt);
  EXPECT_EQ(belt.error().message, "scene test has no conveyor");
}

TEST(CommandCheck, APathIsBoundedInWaypointsAndLength) {
  const auto path = [](std::size_t count, double spacing_m) {
    api::MoveThroughTo move;
    for (std::size_t i = 0; i < count; ++i) {
      move.waypoints.push_back(
          {Pose{{0.4, i % 2 == 0 ? 0 : spacing_m, 0.3}, Eigen::Quaterniond::Identity()}});
    }
    return move;
  };
  EXPECT_EQ(error_of(path(1000, 0.1)), "");
  EXPECT_EQ(error_of(path(1001, 0.01)), "there are 1001 waypoints, the limit is 1000");
  EXPECT_EQ(error_of(path(500, 0.3)), "the path past them is 149.7 m long, the limit is 100 m");
}

TEST(CommandCheck, RefusesNonsenseNumbers) {
  api::MoveTo move;
  EXPECT_EQ(error_of(move), "");
  move.X_RT.p.y() = kNan;
  EXPECT_NE(error_of(move).find("position is"), std::string::npos);
  move.X_RT.p.y() = 0;
  move.X_RT.q.coeffs() *= 2;
  EXPECT_EQ(error_of(move), "the rotation is not a unit quaternion");
  EXPECT_NE(error_of(api::MoveJoints{{{.joint = 0, .position_rad = kNan}}}), "");
  EXPECT_EQ(error_of(api::MoveJoints{{{0, 0, -1.0, {}}}}), "speed is -1.000000, must be above 0");
  EXPECT_EQ(error_of(api::MoveJoints{{{0, 0, {}, 0.0}}}),
            "acceleration is 0.000000, must be above 0");
  EXPECT_EQ(error_of(api::MoveJoints{{{0, 0, {}, {}, api::JointTorque{kNan, {}}}}}),
            "torque is nan, must be above 0");
  EXPECT_EQ(error_of(api::MoveJoints{{{0, 0, {}, {}, api::JointTorque{1, 0.0}}}}),
            "torque change rate is 0.000000, must be above 0");
  EXPECT_NE(error_of(api::SetOverride{1.2}), "");
  EXPECT_NE(error_of(api::SetOverride{kNan}), "");
  EXPECT_NE(error_of(api::SetGripper{1.5}), "");
  EXPECT_NE(error_of(api::SetGripper{kNan}), "");
  EXPECT_NE(error_of(api::SetMotionLimit{api::MotionLimit::kRotSpeed, true, 1.1}), "");
  EXPECT_NE(error_of(api::SetMotionLimit{api::MotionLimit::kRotSpeed, false, -1}), "");
  EXPECT_NE(error_of(api::SetMotionLimit{api::MotionLimit::kTransAccel, false, 0}), "");
  EXPECT_NE(error_of(api::SetMotionLimit{api::MotionLimit::kRotSpeed, false, kNan}), "");
  EXPECT_NE(error_of(api::Dwell{SimTime(-1)}), "");
}

TEST(CommandCheck, AnIntruderHasAPlaceAndASize) {
  const auto error = [](const api::SetIntruder& set) -> std::string {
    const auto ok = checked({.endpoint = 0, .body = set});
    return ok ? "" : ok.error().field;
  };
  EXPECT_EQ(error({}), "");
  api::SetIntruder set{api::Intruder{.X_WI = {}, .size_m = {0.5, 0.3, 1.8}}};
  EXPECT_EQ(error(set), "");
  set.intruder->size_m.y() = 0;
  EXPECT_EQ(error(set), "size");
  set.intruder->size_m.y() = 10.1;
  EXPECT_EQ(error(set), "size");
  set.intruder->size_m.y() = kNan;
  EXPECT_EQ(error(set), "size");
  set.intruder->size_m.y() = 0.3;
  set.intruder->X_WI.p.z() = kNan;
  EXPECT_EQ(error(set), "position");
  set.intruder->X_WI.p.z() = -1001;
  EXPECT_EQ(error(set), "position");
  set.intruder->X_WI.p.z() = 0;
  set.intruder->X_WI.q.coeffs().setZero();
  EXPECT_EQ(error(set), "rotation");
}

TEST(CommandCheck, ASpeedIsWithinAThousandthAndAMillion) {
  const auto field = [](double factor) -> std::string {
    const auto ok = checked({.endpoint = 0, .body = api::SimulationCommand{api::SetSpeed{factor}}});
    return ok ? "" : ok.error().field;
  };
  for (const double good : {1e-3, 0.5, 1.0, 1e6}) EXPECT_EQ(field(good), "") << good;
  for (const double bad : {0.0, -1.0, 1e-13, 9.99e-4, 1.01e6, 1e14, 1e19, kNan,
                           std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(field(bad), "factor") << bad;
  }
}

}  // namespace
}  // namespace aprsim::world
