// Every command as it stands in a journal, and back, number for number.

#include "server/journal/command_message.hpp"

#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "world/api/commands/command_fields.hpp"
#include "world/archive/archive.hpp"

namespace aprsim::server::journal {
namespace {

using namespace std::chrono_literals;

constexpr double kThird = 1.0 / 3;

api::Waypoint waypoint() {
  api::Waypoint out;
  out.X_RT.p = {0.1, -kThird, 1e-300};
  out.X_RT.q = Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5);
  out.limits.trans_speed = api::LimitSetting{true, kThird};
  out.limits.rot_accel = api::LimitSetting{false, 2};
  out.tolerance.y_m = 0.001;
  out.tolerance.z_axis_rad = 0;
  return out;
}

/// One of every alternative at least, with what can be absent both there and absent.
std::vector<api::RobotAction> every_action() {
  api::JointTarget plain{.joint = 2, .position_rad = kThird};
  api::JointTarget full{.joint = 5,
                        .position_rad = -1,
                        .speed_rad_s = 0.5,
                        .accel_rad_s2 = 2,
                        .torque = api::JointTorque{10, 3},
                        .tolerance_rad = 0.1,
                        .held = {{1, 0.5}, {3, -1}}};
  return {api::InitRobot{},
          api::EndProgram{},
          api::StopMotion{api::StopKind::kImmediate},
          api::StopMotion{api::StopKind::kFast},
          api::StopMotion{api::StopKind::kNormal},
          api::MoveTo{waypoint().X_RT, true, waypoint().limits, waypoint().tolerance},
          api::MoveTo{},
          api::MoveThroughTo{{waypoint(), api::Waypoint{}}, true},
          api::MoveScrew{waypoint(), Eigen::Vector3d(1, 2, 3), 0.01, 0.02, 3},
          api::MoveScrew{},
          api::MoveJoints{{plain, full}},
          api::MoveJoints{{plain}, true},
          api::MoveTo{waypoint().X_RT, false, {}, {}, true},
          api::SetGripper{0},
          api::SetGripperForce{12.5},
          api::SetToolChanger{false},
          api::SetToolChanger{true},
          api::SetOverride{0},
          api::Dwell{std::chrono::nanoseconds(1'234'567'890)},
          api::SetMotionLimit{api::MotionLimit::kTransSpeed, true, 0.5},
          api::SetMotionLimit{api::MotionLimit::kRotAccel, false, 1},
          api::SetPlanning{api::PlanningMode::kDirect},
          api::SetPlanning{api::PlanningMode::kAvoid}};
}

std::vector<api::TrajectoryAction> every_trajectory_action() {
  const api::TrajectoryPoint plain{std::chrono::nanoseconds(1), {kThird, -1}};
  const api::TrajectoryPoint full{std::chrono::hours(4), {1, 2}, {kThird, 0}, {1e-300, -2}};
  return {api::ClaimMotion{"driver", api::StreamMode::kTimed},
          api::ClaimMotion{"driver", api::StreamMode::kMoves, true, 12},
          api::AppendPoints{7, true, {plain, full}},
          api::AppendPoints{7},
          api::AppendPoints{7, false, {plain}, std::chrono::nanoseconds(1)},
          api::AppendMove{7, {kThird, 2}, 0.2, 0.5, 3},
          api::StopStream{7},
          api::PauseStream{7, true},
          api::PauseStream{7, false},
          api::PauseStream{7, true, std::chrono::nanoseconds(1)},
          api::ReleaseMotion{7, true},
          api::SwitchGripper{kThird},
          api::FollowTrajectory{"driver"},
          api::FollowTrajectory{.commander = "driver",
                                .joint_names = {"a", "b"},
                                .points = {plain, full},
                                .start = std::chrono::nanoseconds(0),
                                .path_tolerance = {{kThird, 0}, {0, 1}},
                                .goal_tolerance = {{0.5, 0.25}},
                                .reset = true,
                                .goal_time_tolerance = std::chrono::milliseconds(1500)}};
}

std::vector<decltype(api::Command::body)> every_body() {
  std::vector<decltype(api::Command::body)> all;
  for (auto& action : every_action()) all.push_back(api::RobotCommand{1, std::move(action)});
  for (int kind = 0; kind <= static_cast<int>(api::SignalKind::kLightCurtain); ++kind) {
    api::Guard guard{.signal = {static_cast<api::SignalKind>(kind), 1, kind % 2 == 0},
                     .limit = static_cast<api::GuardLimit>(kind % 4),
                     .value = kThird,
                     .recheck = std::chrono::milliseconds(kind),
                     .require_trigger = kind % 2 == 1,
                     .error_on_trigger = kind % 3 == 1,
                     .label = "guard " + std::to_string(kind)};
    all.push_back(api::RobotCommand{0, api::InitRobot{}, {guard, guard}});
  }
  for (auto& action : every_trajectory_action()) {
    all.push_back(api::TrajectoryCommand{1, std::move(action)});
  }
  all.push_back(api::ConveyorCommand{});
  all.push_back(api::ConveyorCommand{.run = false,
                                     .forward = false,
                                     .speed_m_s = 0,
                                     .emergency_stop = false,
                                     .fault_reset = true,
                                     .watchdog_s = 0});
  all.push_back(api::SetSignals{});
  all.push_back(api::SetSignals{{{"scale", "full_kg", kThird}, {"b", "c", -1}}});
  all.push_back(api::SetIntruder{});
  all.push_back(api::SetIntruder{api::Intruder{waypoint().X_RT, {1, 2, 3}}});
  const std::vector<api::FaultTrigger> triggers = {
      std::monostate{},
      api::AtTime{std::chrono::nanoseconds(5'000'000'001)},
      api::WhenPlaced{"gear", "fanuc"},
      api::WhenGrasped{"motoman", 3},
      api::WhenBeamBroken{"entry"},
      api::WhenCrossing{faults::Quantity::kJointPosition, "fanuc", 4, false, -0.5},
      api::WhenCrossing{faults::Quantity::kJointPosition, "fanuc", 1, true, 0.5},
      api::WhenReported{"order"}};
  for (const auto& trigger : triggers) {
    all.push_back(api::FaultCommand(api::InjectFault{.kind = "robot-slow",
                                                     .target = "fanuc",
                                                     .parameters = {{"speed", kThird}},
                                                     .trigger = trigger,
                                                     .duration = std::chrono::seconds(3)}));
  }
  all.push_back(api::FaultCommand(api::InjectFault{}));
  all.push_back(api::FaultCommand(api::EndFault{7}));
  all.push_back(api::FaultCommand(api::ReportEvent{"order"}));
  for (const api::SimulationCommand& command : std::vector<api::SimulationCommand>{
           api::Pause{}, api::Resume{}, api::StepBy{1'000'000'000'000}, api::SetSpeed{2.5},
           api::SetSpeed{}, api::Reset{}, api::Reset{0}, api::SaveState{"a"}, api::LoadState{"b"},
           api::DeleteState{"c"}, api::RunUntil{}, api::RunUntil{api::UntilTime{5s}, 7},
           api::RunUntil{api::UntilEvent{{api::CellEventKind::kGrasped}, {"fanuc"}}},
           api::RunUntil{api::WhenCrossing{faults::Quantity::kBeltTravel, "", 0, false, kThird}},
           api::EndRun{9}}) {
    all.push_back(command);
  }
  for (const api::SceneCommand& command : std::vector<api::SceneCommand>{
           api::SpawnBody{"gear", "spare", waypoint().X_RT}, api::MoveBody{"a", waypoint().X_RT},
           api::RemoveBody{"b"}, api::SetSceneValue{"physics.friction.gear_tray", "0.2"}}) {
    all.push_back(command);
  }
  return all;
}

std::string bits(const api::Command& command) {
  std::string out;
  archive::Writer write(out);
  write(command);
  return out;
}

TEST(CommandMessage, EveryCommandComesBackBitForBit) {
  std::set<std::pair<std::size_t, std::size_t>> kinds;
  for (const auto& body : every_body()) {
    const api::Command command{42, body};
    v1::JournalCommand message, read;
    write_message(command, message);
    ASSERT_TRUE(read.ParseFromString(message.SerializeAsString()));
    const auto back = to_command(read);
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(bits(*back), bits(command)) << message.DebugString();
    const auto inner = std::visit(
        [](const auto& of) -> std::size_t {
          if constexpr (requires { of.action.index(); }) return of.action.index();
          if constexpr (requires { of.index(); }) return of.index();
          return 0;
        },
        body);
    kinds.emplace(body.index(), inner);
  }
  // One that is added has to be added above.
  EXPECT_EQ(kinds.size(), std::variant_size_v<api::RobotAction> +
                              std::variant_size_v<api::FaultCommand> +
                              std::variant_size_v<api::SimulationCommand> +
                              std::variant_size_v<api::TrajectoryAction> +
                              std::variant_size_v<api::SceneCommand> + 3);
}

TEST(CommandMessage, NamesMissingAndUnknownFields) {
  v1::JournalCommand message;
  EXPECT_EQ(to_command(message).error().field, "command");
  message.mutable_robot();
  EXPECT_EQ(to_command(message).error().field, "action of a robot");
  message.mutable_robot()->mutable_stop();
  EXPECT_EQ(to_command(message).error().field, "stop's kind");
  message.mutable_robot()->mutable_stop()->set_kind(static_cast<v1::StopKind>(99));
  EXPECT_EQ(to_command(message).error().field, "stop's kind");
}

}  // namespace
}  // namespace aprsim::server::journal
