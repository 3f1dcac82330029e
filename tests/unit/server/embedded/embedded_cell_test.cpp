// The cell without daemon: its calls, its robots, and that it gives the bits of the daemon's
// thread.

#include "server/embedded/embedded_cell.hpp"

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "aprsim/v1/control_service.pb.h"
#include "aprsim/v1/telemetry_service.pb.h"
#include "crcl/command_codec.hpp"
#include "crcl/framer.hpp"
#include "crcl/status_codec.hpp"
#include "protocols/messages/state_hash.hpp"
#include "protocols/messages/status_code.hpp"
#include "server/embedded/embedded_calls.hpp"
#include "server/embedded/embedded_robot.hpp"
#include "world/runtime/simulation.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::embedded {
namespace {

constexpr int kInvalidArgument = protocols::status_code(ErrorCode::kInvalidArgument);
constexpr int kFailedPrecondition = protocols::status_code(ErrorCode::kFailedPrecondition);

std::shared_ptr<const scene::Scene> shipped(const std::string& name) {
  return std::make_shared<const scene::Scene>(
      scene::load_scene(name, scene::default_data_paths()).value());
}

/// A cell with its robots, as the library has them.
struct Host {
  explicit Host(const std::string& scene = "aprs", std::uint64_t seed = 1)
      : cell(shipped(scene), seed) {
    for (int i = 0; i < static_cast<int>(cell.world().robots().size()); ++i) {
      robots.push_back(std::make_unique<EmbeddedRobot>(i, cell, cell));
    }
  }

  template <typename Response, typename Request>
  Response call(const std::string& method, const Request& request) {
    std::string answer;
    status = embedded::call(cell, method, request.SerializeAsString(), after_step, answer);
    Response response;
    EXPECT_TRUE(response.ParseFromString(answer));
    return response;
  }
  v1::StepResponse step(std::uint64_t steps) {
    v1::StepRequest request;
    request.set_steps(steps);
    request.mutable_read_mask();
    return call<v1::StepResponse>("Control/Step", request);
  }
  std::string document(crcl::CommandBody body) {
    crcl::CommandInstance instance;
    instance.command.id = ++last_id;
    instance.command.body = std::move(body);
    return crcl::encode_command(instance);
  }
  crcl::Status command(std::size_t robot, crcl::CommandBody body) {
    EXPECT_TRUE(robots[robot]->send(document(std::move(body))));
    EXPECT_TRUE(robots[robot]->send(document(crcl::GetStatus{})));
    return crcl::decode_status(robots[robot]->take_statuses()).value();
  }

  EmbeddedCell cell;
  std::vector<std::unique_ptr<EmbeddedRobot>> robots;
  CallStatus status;
  std::int64_t last_id = 0;
  const AfterStep after_step = [this] {
    bool runs = false;
    for (const auto& robot : robots) runs = robot->advance() || runs;
    return runs;
  };
};

/// Waits for a moment of the cell's thread.
api::SnapshotPtr wait_until(const world::Simulation& simulation, std::uint64_t step) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  api::SnapshotPtr now = simulation.latest();
  while (now->step < step && std::chrono::steady_clock::now() < deadline) {
    now = simulation.wait_newer(now, deadline);
  }
  return now;
}

TEST(EmbeddedCell, GivesTheBitsOfTheDaemonsThread) {
  Host host("aprs", 7);
  world::Simulation simulation(shipped("aprs"), {.seed = 7, .speed = std::nullopt, .paused = true});
  simulation.start();
  const std::vector<api::Command> commands = {
      {2, api::RobotCommand{0, api::InitRobot{}}},
      {2, api::RobotCommand{0, api::MoveJoints{{{.joint = 0, .position_rad = 0.4}}}}},
      {2, api::RobotCommand{1, api::InitRobot{}}},
      {2, api::ConveyorCommand{.run = true, .speed_m_s = 0.1}},
  };
  for (const api::Command& command : commands) {
    ASSERT_TRUE(host.cell.submit(command));
    ASSERT_TRUE(simulation.submit(command));
    host.step(100);
    ASSERT_TRUE(simulation.submit({2, api::SimulationCommand(api::StepBy{100})}));
    const auto now = wait_until(simulation, host.cell.latest()->step);
    EXPECT_EQ(protocols::state_hash(*host.cell.latest()), protocols::state_hash(*now));
  }
}

TEST(EmbeddedCell, StepsAndReportsTheMoment) {
  Host host;
  const auto first = host.step(25);
  EXPECT_EQ(host.status.code, 0);
  EXPECT_EQ(first.receipt().step(), 25U);
  EXPECT_EQ(first.snapshot().step(), 25U);
  EXPECT_TRUE(first.snapshot().paused());
  v1::RunUntilRequest run;
  run.mutable_time()->set_seconds(1);
  const auto end = host.call<v1::RunUntilResponse>("Control/RunUntil", run);
  EXPECT_EQ(end.outcome(), v1::RUN_OUTCOME_MET);
  EXPECT_EQ(end.receipt().step(), 1000U);
}

TEST(EmbeddedCell, RunsUntilAnEvent) {
  Host host;
  v1::SpawnBodyRequest spawn;
  spawn.set_type("sku_part_small_gear");
  spawn.set_name("dropped");
  spawn.mutable_body_in_world()->mutable_position_m()->set_z(-3);
  spawn.mutable_body_in_world()->mutable_orientation()->set_w(1);
  host.call<v1::SpawnBodyResponse>("Control/SpawnBody", spawn);
  ASSERT_EQ(host.status.code, 0) << host.status.text;
  v1::RunUntilRequest run;
  run.mutable_event()->add_kinds(v1::CELL_EVENT_KIND_LOST);
  run.set_max_steps(20'000);
  const auto end = host.call<v1::RunUntilResponse>("Control/RunUntil", run);
  EXPECT_EQ(end.outcome(), v1::RUN_OUTCOME_MET) << host.status.text;
  EXPECT_TRUE(end.has_event());
}

TEST(EmbeddedCell, ReturnsToASavedStateWithTheSameBits) {
  Host host;
  host.command(0, crcl::InitCanon{});
  v1::SaveStateRequest save;
  save.set_name("begin");
  host.call<v1::SaveStateResponse>("Control/SaveState", save);
  host.step(300);
  const auto once = protocols::state_hash(*host.cell.latest());
  v1::LoadStateRequest load;
  load.set_name("begin");
  host.call<v1::LoadStateResponse>("Control/LoadState", load);
  EXPECT_EQ(host.status.code, 0) << host.status.text;
  host.step(300);
  EXPECT_EQ(protocols::state_hash(*host.cell.latest()), once);
}

TEST(EmbeddedCell, RefusesAsTheDaemonDoes) {
  Host host;
  v1::LoadStateRequest load;
  load.set_name("nothing");
  host.call<v1::LoadStateResponse>("Control/LoadState", load);
  EXPECT_EQ(host.status.code, protocols::status_code(ErrorCode::kNotFound));
  EXPECT_EQ(host.status.text, "name: no state is saved as 'nothing'; none is saved");
  host.call<v1::ResumeResponse>("Control/Resume", v1::ResumeRequest());
  EXPECT_EQ(host.status.code, kFailedPrecondition);
  v1::StepRequest many;
  many.set_steps(20'000'000);
  host.call<v1::StepResponse>("Control/Step", many);
  EXPECT_EQ(host.status.code, kInvalidArgument);
  host.call<v1::StepResponse>("Journal/GetIncident", v1::StepRequest());
  EXPECT_EQ(host.status.code, protocols::status_code(ErrorCode::kUnimplemented));
  v1::MoveBodyRequest move;
  move.set_name("no_such_body");
  host.call<v1::MoveBodyResponse>("Control/MoveBody", move);
  EXPECT_NE(host.status.code, 0);
  EXPECT_NE(host.status.text.find("no_such_body"), std::string::npos) << host.status.text;
  EXPECT_EQ(host.cell.latest()->step, 0U);
}

TEST(EmbeddedCell, RefusesBytesThatAreNoRequest) {
  Host host;
  std::string answer;
  const auto status = call(host.cell, "Control/Step", "\xff\xff\xff\xff", host.after_step, answer);
  EXPECT_EQ(status.code, kInvalidArgument);
  EXPECT_EQ(status.text, "the request is not a aprsim.v1.StepRequest");
  EXPECT_EQ(answer, "");
}

TEST(EmbeddedRobot, ExecutesCommandsOverTheSteps) {
  Host host;
  EXPECT_EQ(host.command(0, crcl::InitCanon{}).command.state, crcl::CommandState::kWorking);
  host.step(200);
  const double before = host.cell.latest()->robots[0].joints[0].position_rad;
  crcl::ActuateJoints move;
  move.joints.push_back({.joint = 1, .position = 20});
  host.command(0, move);
  host.step(3000);
  const auto now = host.cell.latest();
  EXPECT_EQ(now->robots[0].action.state, api::ActionState::kDone);
  EXPECT_NE(now->robots[0].joints[0].position_rad, before);
}

TEST(EmbeddedRobot, TakesDocumentsInPieces) {
  Host host;
  const std::string document = host.document(crcl::GetStatus{});
  ASSERT_TRUE(host.robots[0]->send(document.substr(0, 20)));
  EXPECT_EQ(host.robots[0]->take_statuses(), "");
  ASSERT_TRUE(host.robots[0]->send(document.substr(20) + document));
  crcl::Framer statuses = crcl::Framer::for_statuses();
  statuses.append(host.robots[0]->take_statuses());
  EXPECT_TRUE(crcl::decode_status(statuses.next().value().value()));
  EXPECT_TRUE(crcl::decode_status(statuses.next().value().value()));
  EXPECT_EQ(statuses.next().value(), std::nullopt);
}

TEST(EmbeddedRobot, ABadDocumentEndsTheConnection) {
  Host host;
  (void)host.robots[0]->send("<CRCLCommandInstance><CRCLCommand></Wrong></CRCLCommandInstance>");
  const auto again = host.robots[0]->send(host.document(crcl::GetStatus{}));
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().message.find("closed the connection"), std::string::npos);
  host.robots[0]->reconnect();
  EXPECT_EQ(host.command(0, crcl::InitCanon{}).command.state, crcl::CommandState::kWorking);
}

TEST(EmbeddedCell, CellsOfSeveralThreadsAreIndependent) {
  const auto run = [](std::uint64_t seed) {
    Host host("aprs", seed);
    host.command(0, crcl::InitCanon{});
    host.step(50);
    crcl::ActuateJoints move;
    move.joints.push_back({.joint = 2, .position = 10});
    host.command(0, move);
    host.step(400);
    return protocols::state_hash(*host.cell.latest());
  };
  const std::vector<std::uint64_t> alone = {run(1), run(2)};
  std::vector<std::uint64_t> beside(8);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < beside.size(); ++i) {
    threads.emplace_back([&beside, &run, i] { beside[i] = run(1 + i % 2); });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < beside.size(); ++i) EXPECT_EQ(beside[i], alone[i % 2]) << i;
}

}  // namespace
}  // namespace aprsim::embedded
