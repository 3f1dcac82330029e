// The ports of both robots before the real cell, in stepped time: nothing moves but by step().

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "protocols/simple_message/controller_state.hpp"
#include "protocols/simple_message/simple_message_server.hpp"
#include "tests/support/cell_script.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/simple_message_client.hpp"
#include "world/runtime/simulation.hpp"

namespace aprsim::simple_message {
namespace {

using test::eventually;
using test::SimpleMessageClient;
using Posture = std::vector<double>;

constexpr int kFanuc = 0, kMotoman = 1;
constexpr double kGoal_rad = 0.01;
constexpr std::chrono::milliseconds kIncrement{4};

/// Cubic polynomial through two points with velocities (Hermite).
double hermite(double p0, double v0, double p1, double v1, double span, double s) {
  const double u = s / span;
  return (1 + 2 * u) * (1 - u) * (1 - u) * p0 + u * u * (3 - 2 * u) * p1 +
         u * (1 - u) * (1 - u) * span * v0 + u * u * (u - 1) * span * v1;
}

/// A cell with the controllers of one scene.
class Ports {
 public:
  Ports() : simulation_(test::load_scene("aprs_2024"), {.paused = true}) {
    simulation_.start();
    for (const int robot : {kFanuc, kMotoman}) {
      SimpleMessageOptions options;
      options.robot = robot;
      options.controller =
          robot == kFanuc ? ControllerKind::kFanucKarel : ControllerKind::kMotomanFs100;
      servers_.push_back(std::make_unique<SimpleMessageServer>(options, simulation_, simulation_));
      ports_.push_back(servers_.back()->start().value());
    }
  }
  ~Ports() {
    for (auto& server : servers_) server->stop();
  }

  void step(std::uint64_t count) {
    const std::uint64_t end = simulation_.latest()->step + count;
    submit(api::SimulationCommand{api::StepBy{count}});
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    for (api::SnapshotPtr now = simulation_.latest(); now->step < end;) {
      if (std::chrono::steady_clock::now() > deadline) throw std::runtime_error("no steps");
      now = simulation_.wait_newer(now, deadline);
    }
  }
  api::Ticket submit(decltype(api::Command::body) body) {
    return simulation_.submit({.endpoint = 0, .body = std::move(body)}).value();
  }
  /// Waits until commands up to this one have taken effect.
  void await(api::Ticket ticket) {
    ASSERT_TRUE(eventually([&] { return simulation_.latest()->applied >= ticket; }));
  }
  void inject(faults::Kind kind, int robot) {
    api::InjectFault fault;
    fault.kind = faults::info(kind).name;
    fault.target = robot == kFanuc ? "fanuc" : "motoman";
    await(submit(api::FaultCommand{fault}));
    step(1);
  }

  [[nodiscard]] api::RobotSnapshot robot(int index) const {
    return simulation_.latest()->robots.at(static_cast<std::size_t>(index));
  }
  [[nodiscard]] Posture measured(int index) const {
    const auto now = robot(index);
    Posture joints;
    for (int i = 0; i < (index == kFanuc ? 6 : 7); ++i) {
      joints.push_back(now.joints.at(static_cast<std::size_t>(i)).position_rad);
    }
    return joints;
  }
  /// A posture near the present one.
  Posture goal(int index, std::mt19937& random) const {
    std::uniform_real_distribution<double> offset(-0.2, 0.2);
    Posture joints = home_[static_cast<std::size_t>(index)];
    for (double& joint : joints) joint += offset(random);
    return joints;
  }
  [[nodiscard]] SimpleMessagePorts ports(int index) const {
    return ports_.at(static_cast<std::size_t>(index));
  }
  world::Simulation& simulation() { return simulation_; }
  void set_home() { home_ = {measured(kFanuc), measured(kMotoman)}; }

 private:
  world::Simulation simulation_;
  std::vector<std::unique_ptr<SimpleMessageServer>> servers_;
  std::vector<SimpleMessagePorts> ports_;
  std::array<Posture, 2> home_;
};

double largest_error(const Posture& a, const Posture& b) {
  double error = 0;
  for (std::size_t i = 0; i < a.size(); ++i) error = std::max(error, std::abs(a[i] - b[i]));
  return error;
}

/// Sends one point and steps the cell until it is acknowledged.
void move_fanuc(Ports& cell, SimpleMessageClient& client, std::int32_t sequence,
                const Posture& posture) {
  client.send({MessageType::kTrajectoryPoint, Communication::kServiceRequest, ReplyCode::kNone,
               TrajectoryPoint{sequence, to_wire(ControllerKind::kFanucKarel, posture), 0.1F, 10}});
  const bool read = eventually(
      [&] {
        if (client.readable(std::chrono::milliseconds(5))) return true;
        cell.step(10);
        return false;
      },
      std::chrono::seconds(60));
  ASSERT_TRUE(read);
  EXPECT_EQ(client.receive_body<JointPosition>().sequence, sequence);
}

void rest(Ports& cell, int robot) {
  const bool rested = eventually(
      [&] {
        const auto now = cell.robot(robot);
        if (now.motion.points_left == 0 && now.motion.phase != api::StreamPhase::kMoving) {
          return true;
        }
        cell.step(10);
        return false;
      },
      std::chrono::seconds(60));
  ASSERT_TRUE(rested);
  cell.step(300);
}

struct MotomanPoint {
  std::int64_t time_ms;
  Joints position, velocity;
};

/// A trajectory at a cosine's speed, a point every 100 ms.
std::vector<MotomanPoint> trajectory_of(const Posture& from, const Posture& to, double duration_s) {
  std::vector<MotomanPoint> points;
  const int count = static_cast<int>(std::lround(duration_s / 0.1));
  for (int i = 0; i <= count; ++i) {
    const double u = static_cast<double>(i) / count;
    const double share = 0.5 - 0.5 * std::cos(std::numbers::pi * u);
    const double speed = 0.5 * std::numbers::pi * std::sin(std::numbers::pi * u) / duration_s;
    MotomanPoint point{i * 100, {}, {}};
    for (std::size_t j = 0; j < from.size(); ++j) {
      point.position[j] = static_cast<float>(from[j] + share * (to[j] - from[j]));
      point.velocity[j] = static_cast<float>(speed * (to[j] - from[j]));
    }
    points.push_back(point);
  }
  return points;
}

MotionReply send_point(SimpleMessageClient& client, std::int32_t sequence,
                       const MotomanPoint& point) {
  return client.ask<MotionReply>(MessageType::kTrajectoryPointFull,
                                 TrajectoryPointFull{0,
                                                     sequence,
                                                     7,
                                                     static_cast<float>(point.time_ms) / 1000,
                                                     point.position,
                                                     point.velocity,
                                                     {}});
}

/// Sends a trajectory as the laboratory's client does: a point a cycle of 25 ms, again when busy.
int move_motoman(
    Ports& cell, SimpleMessageClient& client, const std::vector<MotomanPoint>& points,
    const std::function<void()>& each_cycle = [] {}) {
  int busy = 0;
  for (std::size_t i = 0; i < points.size();) {
    const auto reply = send_point(client, static_cast<std::int32_t>(i), points[i]);
    EXPECT_TRUE(reply.result == 0 || reply.result == 1) << reply.result << " " << reply.subcode;
    if (reply.result > 1) break;
    if (reply.result == 0) {
      ++i;
    } else {
      ++busy;
    }
    each_cycle();
    cell.step(25);
  }
  return busy;
}

MotionReply control(SimpleMessageClient& client, MotionCommand command) {
  return client.ask<MotionReply>(MessageType::kMotionControl,
                                 MotionControl{0, 0, static_cast<std::int32_t>(command), {}});
}

RobotStatus status(Ports& cell, int robot) {
  SimpleMessageClient client(cell.ports(robot).state);
  while (true) {
    const Message message = client.receive();
    if (message.type == MessageType::kRobotStatus) return std::get<RobotStatus>(message.body);
  }
}

/// START_TRAJ_MODE; steps the cell until it is answered, since drives take a while.
std::int32_t start_mode(Ports& cell, SimpleMessageClient& client) {
  const auto number = static_cast<std::int32_t>(MotionCommand::kStartTrajectoryMode);
  client.send({MessageType::kMotionControl, Communication::kServiceRequest, ReplyCode::kNone,
               MotionControl{0, 0, number, {}}});
  EXPECT_TRUE(eventually([&] {
    if (client.readable(std::chrono::milliseconds(5))) return true;
    cell.step(10);
    return false;
  }));
  return client.receive_body<MotionReply>().result;
}

TEST(RealCell, TheFanucReachesRandomGoals) {
  Ports cell;
  cell.step(100);
  cell.set_home();
  std::mt19937 random(11);
  SimpleMessageClient client(cell.ports(kFanuc).motion);
  for (int i = 0; i < 5; ++i) {
    const Posture from = cell.measured(kFanuc), to = cell.goal(kFanuc, random);
    for (int j = 0; j <= 5; ++j) {
      Posture point = from;
      for (std::size_t k = 0; k < point.size(); ++k) point[k] += j * (to[k] - from[k]) / 5;
      move_fanuc(cell, client, j, point);
    }
    rest(cell, kFanuc);
    EXPECT_LT(largest_error(cell.measured(kFanuc), to), kGoal_rad) << i;
    EXPECT_TRUE(cell.robot(kFanuc).motion.alarm.empty()) << cell.robot(kFanuc).motion.alarm;
  }
}

TEST(RealCell, TheMotomanReachesRandomGoals) {
  Ports cell;
  cell.step(100);
  cell.set_home();
  std::mt19937 random(12);
  SimpleMessageClient client(cell.ports(kMotoman).motion);
  ASSERT_EQ(start_mode(cell, client), 0);
  int busy = 0;
  for (int i = 0; i < 5; ++i) {
    const Posture to = cell.goal(kMotoman, random);
    busy += move_motoman(cell, client, trajectory_of(cell.measured(kMotoman), to, 2));
    rest(cell, kMotoman);
    EXPECT_LT(largest_error(cell.measured(kMotoman), to), kGoal_rad) << i;
    EXPECT_TRUE(cell.robot(kMotoman).motion.alarm.empty()) << cell.robot(kMotoman).motion.alarm;
  }
  EXPECT_GT(busy, 0);
  EXPECT_EQ(control(client, MotionCommand::kStopTrajectoryMode).result, 0);
  EXPECT_TRUE(
      eventually([&] { return cell.robot(kMotoman).motion.source == api::MotionSource::kNone; }));
}

TEST(RealCell, EveryIncrementIsWithinAPulseOfTheCubic) {
  Ports cell;
  cell.step(100);
  cell.set_home();
  std::mt19937 random(13);
  SimpleMessageClient client(cell.ports(kMotoman).motion);
  ASSERT_EQ(start_mode(cell, client), 0);
  const Posture from = cell.measured(kMotoman);
  const auto points = trajectory_of(from, cell.goal(kMotoman, random), 1);
  // Whole in the queue but for the last 0.2 s.
  std::size_t sent = 0;
  int compared = 0;
  const auto send_more = [&] {
    while (sent < points.size() &&
           send_point(client, static_cast<std::int32_t>(sent), points[sent]).result == 0) {
      ++sent;
    }
  };
  for (send_more(); compared < 250; send_more()) {
    cell.step(static_cast<std::uint64_t>(kIncrement.count()));
    const api::MotionSnapshot motion = cell.robot(kMotoman).motion;
    const double time_ms = std::chrono::duration<double, std::milli>(motion.time).count();
    const auto segment = std::min<std::size_t>(static_cast<std::size_t>(time_ms / 100), 9);
    const MotomanPoint &a = points[segment], &b = points[segment + 1];
    std::vector<double> wanted, is;
    for (std::size_t j = 0; j < 7; ++j) {
      // The motion begins where the robot is commanded to be, within the 30 pulses.
      if (segment == 0) continue;
      wanted.push_back(hermite(a.position[j], a.velocity[j], b.position[j], b.velocity[j], 0.1,
                               (time_ms - static_cast<double>(a.time_ms)) / 1000));
      is.push_back(motion.reference_rad[j]);
    }
    if (!wanted.empty()) {
      EXPECT_TRUE(within_pulses(is, wanted, 1)) << time_ms;
    }
    ++compared;
  }
  EXPECT_EQ(sent, points.size());
}

TEST(RealCell, TheSameBitsTwice) {
  const auto run = [] {
    Ports cell;
    cell.step(100);
    cell.set_home();
    std::mt19937 random(14);
    SimpleMessageClient fanuc(cell.ports(kFanuc).motion), motoman(cell.ports(kMotoman).motion);
    control(motoman, MotionCommand::kStartTrajectoryMode);
    // Two points at once: neither waits for the motion.
    for (const int sequence : {0, 1}) {
      const Joints to = to_wire(ControllerKind::kFanucKarel, cell.goal(kFanuc, random));
      fanuc.send({MessageType::kTrajectoryPoint, Communication::kServiceRequest, ReplyCode::kNone,
                  TrajectoryPoint{sequence, to, 0.1F, 10}});
      fanuc.receive();
    }
    std::vector<double> trace;
    const auto record = [&] {
      for (const int robot : {kFanuc, kMotoman}) {
        for (const double joint : cell.measured(robot)) trace.push_back(joint);
      }
    };
    move_motoman(cell, motoman,
                 trajectory_of(cell.measured(kMotoman), cell.goal(kMotoman, random), 1.5), record);
    cell.step(1000);
    record();
    return trace;
  };
  const auto first = run();
  EXPECT_GT(first.size(), 100U);
  EXPECT_EQ(first, run());
}

TEST(RealCell, AGoalThatComesTooEarlyIsRefusedAtItsStart) {
  Ports cell;
  cell.step(100);
  cell.set_home();
  std::mt19937 random(15);
  SimpleMessageClient client(cell.ports(kMotoman).motion);
  start_mode(cell, client);
  const auto points = trajectory_of(cell.measured(kMotoman), cell.goal(kMotoman, random), 1);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(send_point(client, static_cast<std::int32_t>(i), points[i]).result, 0);
  }
  cell.step(400);
  MotomanPoint start{0, to_wire(ControllerKind::kMotomanFs100, cell.measured(kMotoman)), {}};
  start.position[0] += 0.01F;
  const auto reply = send_point(client, 0, start);
  EXPECT_EQ(reply.result, 3);
  EXPECT_EQ(reply.subcode, 3011);
}

TEST(RealCell, ALostClientsQueueStopsAndGoesOn) {
  Ports cell;
  cell.step(100);
  cell.set_home();
  std::mt19937 random(16);
  const Posture to = cell.goal(kMotoman, random);
  {
    SimpleMessageClient client(cell.ports(kMotoman).motion);
    start_mode(cell, client);
    const auto points = trajectory_of(cell.measured(kMotoman), to, 0.8);
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(send_point(client, static_cast<std::int32_t>(i), points[i]).result, 0);
    }
    cell.step(300);
  }
  ASSERT_TRUE(
      eventually([&] { return cell.robot(kMotoman).motion.phase == api::StreamPhase::kPaused; }));
  cell.step(500);
  const Posture stands = cell.measured(kMotoman);
  EXPECT_GT(largest_error(stands, to), kGoal_rad);
  cell.step(200);
  EXPECT_LT(largest_error(cell.measured(kMotoman), stands), 1e-3);
  SimpleMessageClient next(cell.ports(kMotoman).motion);
  ASSERT_TRUE(
      eventually([&] { return cell.robot(kMotoman).motion.phase == api::StreamPhase::kMoving; }));
  rest(cell, kMotoman);
  EXPECT_LT(largest_error(cell.measured(kMotoman), to), kGoal_rad);
}

TEST(RealCell, PointsThatWereNotCutAreLostWithTheirClient) {
  Ports cell;
  cell.step(100);
  cell.set_home();
  const Posture from = cell.measured(kMotoman);
  Posture to = from;
  to[0] += 0.4;
  {
    SimpleMessageClient client(cell.ports(kMotoman).motion);
    start_mode(cell, client);
    MotomanPoint start{0, to_wire(ControllerKind::kMotomanFs100, from), {}};
    EXPECT_EQ(send_point(client, 0, start).result, 0);
    EXPECT_EQ(send_point(client, 1, {2000, to_wire(ControllerKind::kMotomanFs100, to), {}}).result,
              0);
    cell.step(300);
  }
  ASSERT_TRUE(
      eventually([&] { return cell.robot(kMotoman).motion.phase == api::StreamPhase::kPaused; }));
  cell.step(500);
  SimpleMessageClient next(cell.ports(kMotoman).motion);
  ASSERT_TRUE(
      eventually([&] { return cell.robot(kMotoman).motion.phase == api::StreamPhase::kMoving; }));
  rest(cell, kMotoman);
  // The queue held 0.8 s more: it runs out there, and the robot brakes.
  const api::MotionSnapshot motion = cell.robot(kMotoman).motion;
  const double end_s = std::chrono::duration<double>(motion.time).count();
  EXPECT_GE(end_s, 1.1);
  EXPECT_LE(end_s, 1.2);
  const double way = cell.measured(kMotoman)[0] - from[0];
  EXPECT_GT(way, hermite(0, 0, 0.4, 0, 2, end_s));
  EXPECT_LT(way, 0.39);
  EXPECT_EQ(control(next, MotionCommand::kCheckQueueCount).subcode, 0);
  EXPECT_TRUE(motion.alarm.empty()) << motion.alarm;
}

TEST(RealCell, WhatTheFanucWasHandedIsFinishedWithoutItsClient) {
  Ports cell;
  cell.step(100);
  cell.set_home();
  std::mt19937 random(17);
  const Posture to = cell.goal(kFanuc, random);
  {
    SimpleMessageClient client(cell.ports(kFanuc).motion);
    move_fanuc(cell, client, 0, to);
    cell.step(20);
  }
  ASSERT_TRUE(eventually([&] {
    cell.step(20);
    return cell.robot(kFanuc).motion.source == api::MotionSource::kNone;
  }));
  cell.step(300);
  EXPECT_LT(largest_error(cell.measured(kFanuc), to), kGoal_rad);
}

TEST(RealCell, StopMotionDropsTheQueue) {
  Ports cell;
  cell.step(100);
  cell.set_home();
  std::mt19937 random(18);
  SimpleMessageClient client(cell.ports(kMotoman).motion);
  start_mode(cell, client);
  const auto points = trajectory_of(cell.measured(kMotoman), cell.goal(kMotoman, random), 1);
  for (std::size_t i = 0; i < 8; ++i) {
    send_point(client, static_cast<std::int32_t>(i), points[i]);
  }
  cell.step(400);
  EXPECT_EQ(control(client, MotionCommand::kStopMotion).result, 0);
  EXPECT_EQ(control(client, MotionCommand::kCheckQueueCount).subcode, 0);
  cell.step(500);
  const Posture stands = cell.measured(kMotoman);
  // A new trajectory may follow.
  const Posture to = cell.goal(kMotoman, random);
  move_motoman(cell, client, trajectory_of(stands, to, 1));
  rest(cell, kMotoman);
  EXPECT_LT(largest_error(cell.measured(kMotoman), to), kGoal_rad);
}

TEST(RealCell, AProtectiveStopIsAnAlarmUntilItIsReset) {
  Ports cell;
  cell.step(100);
  SimpleMessageClient client(cell.ports(kMotoman).motion);
  start_mode(cell, client);
  cell.inject(faults::Kind::kProtectiveStop, kMotoman);
  cell.step(500);
  const MotomanPoint start{0, to_wire(ControllerKind::kMotomanFs100, cell.measured(kMotoman)), {}};
  const auto reply = send_point(client, 0, start);
  EXPECT_EQ(reply.result, 5);
  EXPECT_EQ(reply.subcode, 5001);
  EXPECT_EQ(status(cell, kMotoman).in_error, 1);
  EXPECT_EQ(status(cell, kFanuc).in_error, 0);
  EXPECT_EQ(start_mode(cell, client), 0);
  cell.step(500);
  EXPECT_EQ(status(cell, kMotoman).in_error, 0);
  EXPECT_EQ(status(cell, kMotoman).motion_possible, 1);
}

TEST(RealCell, AnEmergencyStopEndsTrajectories) {
  Ports cell;
  cell.step(100);
  SimpleMessageClient client(cell.ports(kMotoman).motion);
  start_mode(cell, client);
  cell.inject(faults::Kind::kRobotEmergencyStop, kMotoman);
  cell.step(500);
  const RobotStatus now = status(cell, kMotoman);
  EXPECT_EQ(now.e_stopped, 1);
  EXPECT_EQ(now.drives_powered, 0);
  EXPECT_EQ(now.motion_possible, 0);
  const auto reply = control(client, MotionCommand::kStartTrajectoryMode);
  EXPECT_EQ(reply.result, 5);
  EXPECT_EQ(reply.subcode, 5003);
}

TEST(RealCell, APointBeyondALimitIsAnAlarm) {
  Ports cell;
  cell.step(100);
  SimpleMessageClient client(cell.ports(kMotoman).motion);
  start_mode(cell, client);
  MotomanPoint point{0, to_wire(ControllerKind::kMotomanFs100, cell.measured(kMotoman)), {}};
  EXPECT_EQ(send_point(client, 0, point).result, 0);
  point.time_ms = 1000;
  point.position[1] = 2.5F;
  EXPECT_EQ(send_point(client, 1, point).result, 0) << "MotoROS checks no position";
  ASSERT_TRUE(eventually([&] { return !cell.robot(kMotoman).motion.alarm.empty(); }));
  const auto reply = send_point(client, 2, point);
  EXPECT_EQ(reply.result, 5);
  EXPECT_EQ(reply.subcode, 5001);
  EXPECT_EQ(status(cell, kMotoman).in_error, 1);
}

TEST(RealCell, GrippersFollowTheirWires) {
  Ports cell;
  cell.step(100);
  SimpleMessageClient fanuc(cell.ports(kFanuc).gripper), motoman(cell.ports(kMotoman).gripper);
  const auto write = [&](std::int32_t address, std::int32_t value) {
    EXPECT_EQ(motoman.ask<WriteIoReply>(MessageType::kWriteIoBit, WriteIo{address, value}).result,
              0);
  };
  const auto word = [&](std::int32_t command) {
    fanuc.send_bytes(encode_word(command, ByteOrder::kBig));
    return fanuc.take(4);
  };
  const double open_fanuc = cell.robot(kFanuc).gripper.separation_m;
  const double open_motoman = cell.robot(kMotoman).gripper.separation_m;
  word(1);
  write(10012, 1);
  write(10010, 0);
  cell.step(3);
  write(10011, 1);
  cell.step(1000);
  // Strokes of a finger: 7.5 and 20 mm.
  EXPECT_NEAR(open_fanuc - cell.robot(kFanuc).gripper.separation_m, 0.015, 5e-4);
  EXPECT_NEAR(open_motoman - cell.robot(kMotoman).gripper.separation_m, 0.04, 5e-4);
  EXPECT_EQ(word(3), encode_word(1, ByteOrder::kBig));
  word(0);
  write(10012, 0);
  write(10010, 1);
  write(10011, 0);
  cell.step(1000);
  EXPECT_NEAR(cell.robot(kFanuc).gripper.separation_m, open_fanuc, 5e-4);
  EXPECT_NEAR(open_motoman - cell.robot(kMotoman).gripper.separation_m, 0.04, 5e-4) << "no air";
  write(10012, 1);
  cell.step(1000);
  EXPECT_NEAR(cell.robot(kMotoman).gripper.separation_m, open_motoman, 5e-4);
}

TEST(RealCell, GrippersNeedNoReadyRobot) {
  Ports cell;
  cell.step(100);
  const api::Ticket move = cell.submit(api::RobotCommand{kFanuc, api::Dwell{}});
  cell.await(move);
  cell.step(1);
  ASSERT_EQ(cell.robot(kFanuc).action.state, api::ActionState::kError) << "not initialized";
  SimpleMessageClient gripper(cell.ports(kFanuc).gripper);
  gripper.send_bytes(encode_word(1, ByteOrder::kBig));
  gripper.take(4);
  cell.step(1000);
  EXPECT_LT(cell.robot(kFanuc).gripper.separation_m, 0.006);
  EXPECT_EQ(cell.robot(kFanuc).action.ticket, move) << "the status shows nothing of it";
  EXPECT_EQ(cell.robot(kFanuc).action.state, api::ActionState::kError);
}

TEST(RealCell, GrippersMoveBesideAStream) {
  Ports cell;
  cell.step(100);
  cell.set_home();
  std::mt19937 random(19);
  SimpleMessageClient client(cell.ports(kFanuc).motion), gripper(cell.ports(kFanuc).gripper);
  move_fanuc(cell, client, 0, cell.goal(kFanuc, random));
  gripper.send_bytes(encode_word(1, ByteOrder::kBig));
  gripper.take(4);
  cell.step(1000);
  EXPECT_LT(cell.robot(kFanuc).gripper.setting, 0.5);
  EXPECT_LT(cell.robot(kFanuc).gripper.separation_m, 0.006);
}

}  // namespace
}  // namespace aprsim::simple_message
