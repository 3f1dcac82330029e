// The CRCL server before the real simulation, stepped: what goes on while another command comes,
// and what ends.

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "protocols/crcl/crcl_server.hpp"
#include "tests/support/cell_script.hpp"
#include "tests/unit/crcl/samples.hpp"
#include "tests/unit/protocols/crcl/test_client.hpp"
#include "world/runtime/simulation.hpp"

namespace aprsim::crcl_server {
namespace {

using crcl::CommandState;

class BesideMotion : public testing::Test {
 protected:
  explicit BesideMotion(std::shared_ptr<const scene::Scene> scene = test::load_scene("fanuc_only"))
      : simulation_(std::move(scene), {.paused = true}) {
    simulation_.start();
    CrclServerOptions options;
    options.listener.port = 0;
    server_ = std::make_unique<CrclServer>(options, simulation_, simulation_);
    port_ = server_->start().value();
    client_ = std::make_unique<TestClient>(port_);
    run(++id_, "InitCanonType");
    // To where there is room all round.
    run(++id_, "MoveToType", move(start_, false));
    run(++id_, "SetTransSpeedType",
        "<TransSpeed xsi:type=\"TransSpeedAbsoluteType\"><Setting>100</Setting></TransSpeed>");
  }
  ~BesideMotion() override { server_->stop(); }

  static std::string move(double x_mm, bool straight = true, double z_mm = 300) {
    return std::string("<MoveStraight>") + (straight ? "true" : "false") +
           "</MoveStraight><EndPosition><Point><X>" + std::to_string(x_mm) + "</X><Y>0</Y><Z>" +
           std::to_string(z_mm) +
           "</Z></Point><XAxis><I>1</I><J>0</J><K>0</K></XAxis>"
           "<ZAxis><I>0</I><J>0</J><K>-1</K></ZAxis></EndPosition>";
  }

  /// Steps of one millisecond; returns after the last.
  void step(std::uint64_t count) {
    const std::uint64_t end = simulation_.latest()->step + count;
    const auto ticket =
        simulation_.submit({.endpoint = 0, .body = api::SimulationCommand{api::StepBy{count}}});
    ASSERT_TRUE(ticket);
    wait([&](const api::Snapshot& now) { return now.step >= end; });
  }
  template <typename Condition>
  api::SnapshotPtr wait(Condition condition) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    api::SnapshotPtr now = simulation_.latest();
    while (!condition(*now)) {
      if (std::chrono::steady_clock::now() > deadline) {
        ADD_FAILURE() << "waited in vain";
        break;
      }
      now = simulation_.wait_newer(now, deadline);
    }
    return now;
  }

  /// Sends a command; the world has taken it when this returns.
  crcl::Status send(TestClient& client, std::int64_t id, const std::string& type,
                    const std::string& body = "") {
    client.command(id, type, body);
    const crcl::Status status = client.status();
    EXPECT_EQ(status.command.command_id, id);
    const auto taken =
        simulation_.submit({.endpoint = 0, .body = api::SimulationCommand{api::Pause{}}});
    EXPECT_TRUE(taken);
    wait([&](const api::Snapshot& now) { return now.applied >= *taken; });
    return status;
  }
  crcl::Status send(std::int64_t id, const std::string& type, const std::string& body = "") {
    return send(*client_, id, type, body);
  }
  /// Sends it and steps until it is done.
  crcl::Status run(TestClient& client, std::int64_t id, const std::string& type,
                   const std::string& body = "") {
    send(client, id, type, body);
    for (int i = 0; i < 400; ++i) {
      const crcl::Status status = client.status();
      EXPECT_EQ(status.command.command_id, id);
      if (status.command.state != CommandState::kWorking) {
        EXPECT_EQ(crcl::name_of(status.command.state), crcl::name_of(CommandState::kDone))
            << type << ": " << status.command.description.value_or("");
        return status;
      }
      step(50);
    }
    ADD_FAILURE() << type << " does not end";
    return {};
  }
  crcl::Status run(std::int64_t id, const std::string& type, const std::string& body = "") {
    return run(*client_, id, type, body);
  }

  [[nodiscard]] const api::RobotSnapshot robot() const { return simulation_.latest()->robots[0]; }
  [[nodiscard]] double x_mm() const { return robot().X_RT.p.x() * 1e3; }
  /// A move of two seconds by 200 mm, half a second after its begin.
  void set_out() {
    send(++id_, "MoveToType", move(start_ + 200));
    step(500);
    EXPECT_TRUE(robot().moving);
    EXPECT_GT(x_mm(), start_ + 10);
  }
  void expect_arrival() {
    for (int i = 0; i < 100 && robot().moving; ++i) step(50);
    EXPECT_NEAR(x_mm(), start_ + 200, 1e-3);
  }
  static void expect(const crcl::Status& status, std::int64_t id, CommandState state,
                     const std::string& description = "") {
    EXPECT_EQ(status.command.command_id, id);
    EXPECT_EQ(crcl::name_of(status.command.state), crcl::name_of(state));
    EXPECT_EQ(status.command.description.value_or(""), description);
  }

  static constexpr double start_ = 380;
  world::Simulation simulation_;
  std::unique_ptr<CrclServer> server_;
  std::uint16_t port_ = 0;
  std::unique_ptr<TestClient> client_;
  std::int64_t id_ = 3;
};

TEST_F(BesideMotion, ADwellRunsWhileTheMoveGoesOnToItsTarget) {
  set_out();
  const std::int64_t dwell = ++id_;
  expect(send(dwell, "DwellType", "<DwellTime>0.3</DwellTime>"), dwell, CommandState::kWorking);
  step(299);
  expect(client_->status(), dwell, CommandState::kWorking);
  step(2);
  expect(client_->status(), dwell, CommandState::kDone);
  EXPECT_TRUE(robot().moving);
  expect_arrival();
  expect(client_->status(), dwell, CommandState::kDone);
}

TEST_F(BesideMotion, TheGripperClosesWhileTheMoveGoesOn) {
  set_out();
  const std::int64_t close = ++id_;
  const double open_m = robot().gripper.separation_m;
  send(close, "SetEndEffectorType", "<Setting>0</Setting>");
  step(1);
  expect(client_->status(), close, CommandState::kDone);
  EXPECT_GT(robot().gripper.separation_m, open_m - 1e-3) << "done before the fingers have moved";
  step(400);
  EXPECT_LT(robot().gripper.separation_m, open_m - 5e-3);
  EXPECT_TRUE(robot().moving);
  expect_arrival();
}

TEST_F(BesideMotion, SettingsAndMessagesAreDoneInTheirOrderAndLeaveTheMove) {
  set_out();
  const std::string tolerance =
      "<Tolerance><XPointTolerance>1</XPointTolerance><YPointTolerance>1</YPointTolerance>"
      "<ZPointTolerance>1</ZPointTolerance><XAxisTolerance>1</XAxisTolerance>"
      "<ZAxisTolerance>1</ZAxisTolerance></Tolerance>";
  for (const auto& [type, body] : std::initializer_list<std::pair<std::string, std::string>>{
           {"SetLengthUnitsType", "<UnitName>meter</UnitName>"},
           {"SetAngleUnitsType", "<UnitName>radian</UnitName>"},
           {"SetEndPoseToleranceType", tolerance},
           {"SetRotSpeedType",
            "<RotSpeed xsi:type=\"RotSpeedAbsoluteType\"><Setting>0.1</Setting></RotSpeed>"},
           {"SetTransSpeedType",
            "<TransSpeed "
            "xsi:type=\"TransSpeedAbsoluteType\"><Setting>0.01</Setting></TransSpeed>"}}) {
    const std::int64_t id = ++id_;
    send(id, type, body);
    expect(client_->status(), id, CommandState::kDone);
  }
  const std::int64_t message = ++id_;
  send(message, "MessageType", "<Message>on the way</Message>");
  expect(client_->status(), message, CommandState::kDone, "on the way");
  EXPECT_TRUE(robot().moving);
  expect_arrival();
}

TEST_F(BesideMotion, AMoveThatAnotherCommandEndsIsToldOf) {
  set_out();
  const std::int64_t first = id_, stop = ++id_;
  const crcl::Status stopped = run(stop, "StopMotionType", "<StopCondition>Normal</StopCondition>");
  expect(stopped, stop, CommandState::kDone,
         "MoveToType " + std::to_string(first) + " ended before its target.");
  // It has ended: nothing else ends it again.
  const std::int64_t next = ++id_;
  expect(run(next, "MoveToType", move(start_)), next, CommandState::kDone);
  // Also behind a command beside it.
  set_out();
  const std::int64_t second = id_;
  send(++id_, "SetEndEffectorType", "<Setting>1</Setting>");
  const std::int64_t instead = ++id_;
  expect(run(instead, "MoveToType", move(start_)), instead, CommandState::kDone,
         "MoveToType " + std::to_string(second) + " ended before its target.");
  EXPECT_NEAR(x_mm(), start_, 1e-3);
}

/// The framework's pause: StopMotion on another socket with a lower id, later InitCanon with an id
/// lower still and the interrupted command again.
TEST_F(BesideMotion, AStoppedMoveGoesOnAfterInitCanonAndTheSameCommand) {
  set_out();
  const std::int64_t interrupted = id_;
  TestClient stopper(port_);
  run(stopper, interrupted - 1, "StopMotionType", "<StopCondition>Fast</StopCondition>");
  const double stopped_mm = x_mm();
  EXPECT_LT(stopped_mm, start_ + 190);
  // A second later the drives are off.
  step(1500);
  EXPECT_FALSE(robot().drives_on);
  EXPECT_NEAR(x_mm(), stopped_mm, 1e-6);
  run(interrupted - 3, "InitCanonType");
  EXPECT_NEAR(x_mm(), stopped_mm, 1e-6);
  run(interrupted, "MoveToType", move(start_ + 200));
  EXPECT_NEAR(x_mm(), start_ + 200, 1e-3);
}

/// A client that closes and connects again finds the state of its command, and goes on.
TEST_F(BesideMotion, AClientThatReconnectsGoesOnWhereItWas) {
  set_out();
  const std::int64_t under_way = id_;
  client_.reset();
  client_ = std::make_unique<TestClient>(port_);
  expect(client_->status(), under_way, CommandState::kWorking);
  expect_arrival();
  expect(client_->status(), under_way, CommandState::kDone);
  // Without InitCanon, or with one.
  run(++id_, "MoveToType", move(start_));
  run(++id_, "InitCanonType");
  run(++id_, "MoveToType", move(start_ + 200));
  EXPECT_NEAR(x_mm(), start_ + 200, 1e-3);
}

/// A killed controller: the arm brakes and stays until InitCanon.
TEST_F(BesideMotion, ALostConnectionStopsTheMove) {
  set_out();
  TestClient witness(port_);
  client_->reset();
  witness.wait_for([](const crcl::Status& s) { return s.command.state == CommandState::kError; });
  step(400);
  EXPECT_FALSE(robot().moving);
  EXPECT_LT(x_mm(), start_ + 190);
  run(witness, ++id_, "InitCanonType");
  run(witness, ++id_, "MoveToType", move(start_ + 200));
  EXPECT_NEAR(x_mm(), start_ + 200, 1e-3);
}

/// InitCanon while the arm moves: it stops without leaving the path and is ready again.
TEST_F(BesideMotion, InitCanonEndsAMoveAndTellsOfIt) {
  set_out();
  const std::int64_t first = id_, init = ++id_;
  expect(run(init, "InitCanonType"), init, CommandState::kDone,
         "MoveToType " + std::to_string(first) + " ended before its target.");
  EXPECT_FALSE(robot().moving);
  EXPECT_LT(x_mm(), start_ + 190);
  run(++id_, "MoveToType", move(start_ + 200));
  EXPECT_NEAR(x_mm(), start_ + 200, 1e-3);
}

/// A fork under the palm of the tool 100 mm below the start.
class ToolChange : public BesideMotion {
 protected:
  ToolChange() : BesideMotion(with_fork()) { run(++id_, "MoveToType", move(start_, true, 200)); }

  static std::shared_ptr<const scene::Scene> with_fork() {
    auto scene = *test::load_scene("fanuc_only");
    const scene::Gripper& gripper = scene.robots[0].gripper;
    for (const double side : {-1.0, 1.0}) {
      Pose X_WS;
      X_WS.p = {1e-3 * start_ + side * 0.03, 0, 0.2 + gripper.pad_height_m - 0.0105};
      scene.fixed.push_back({side < 0 ? "fork_1" : "fork_2", {0.03, 0.1, 0.02}, X_WS});
    }
    return std::make_shared<const scene::Scene>(std::move(scene));
  }
};

TEST_F(ToolChange, OpenCloseAndGripperBackToBackAreDoneInTheirOrder) {
  const double open_m = robot().gripper.separation_m;
  client_->command(++id_, "OpenToolChangerType");
  client_->command(++id_, "CloseToolChangerType");
  send(++id_, "SetEndEffectorType", "<Setting>0</Setting>");
  bool opened = false;
  for (int i = 0; i < 100 && robot().gripper.separation_m > open_m - 5e-3; ++i) {
    step(20);
    opened = opened || robot().tool < 0;
  }
  EXPECT_TRUE(opened);
  expect(client_->status(), id_, CommandState::kDone);
  EXPECT_EQ(robot().tool, 0);
  EXPECT_LT(robot().gripper.separation_m, open_m - 5e-3);
  run(++id_, "MoveToType", move(start_));
  EXPECT_EQ(robot().tool, 0);
  EXPECT_FALSE(robot().protective_stop);
}

TEST_F(ToolChange, AwayFromTheToolTheGripperIsRefusedAndTheRobotGoesOn) {
  run(++id_, "OpenToolChangerType");
  // The point that goes there is now the flange.
  run(++id_, "MoveToType", move(start_, true, 500));
  const std::int64_t close = ++id_;
  expect(run(close, "CloseToolChangerType"), close, CommandState::kDone,
         "nothing taken: no tool is at the flange");
  send(++id_, "SetEndEffectorType", "<Setting>0</Setting>");
  step(50);
  const crcl::Status status = client_->status();
  EXPECT_EQ(crcl::name_of(status.command.state), crcl::name_of(CommandState::kError));
  EXPECT_EQ(status.command.description.value_or("").rfind("no tool is on the robot", 0), 0u);
}

}  // namespace
}  // namespace aprsim::crcl_server
