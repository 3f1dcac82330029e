// aprsim.crcl.v1.RobotService: by the rules of the CRCL port, whatever wire a command comes on.

#include <future>
#include <thread>
#include <variant>

#include <gtest/gtest.h>

#include "aprsim/crcl/v1/robot_service.grpc.pb.h"
#include "protocols/crcl/crcl_server.hpp"
#include "tests/unit/protocols/grpc/telemetry_fixture.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;
using api::ActionState;
namespace pb = crcl::v1;

constexpr api::EndpointId kCrclEndpoint = 16;

/// The ports of a cell with one robot.
class OnePort final : public protocols::RobotPorts {
 public:
  void set(std::shared_ptr<protocols::RobotPort> port) { port_ = std::move(port); }
  [[nodiscard]] std::shared_ptr<protocols::RobotPort> find(
      const std::string& robot) const override {
    return port_ && port_->robot() == robot ? port_ : nullptr;
  }
  [[nodiscard]] std::vector<std::string> names() const override {
    return port_ ? std::vector{port_->robot()} : std::vector<std::string>();
  }

 private:
  std::shared_ptr<protocols::RobotPort> port_;
};

class RobotService : public TelemetryFixture {
 protected:
  void SetUp() override { start_robots({}); }
  void TearDown() override {
    if (server_) server_->stop();
    if (robot_) robot_->stop();
    server_.reset();
  }

  void start_robots(grpc_server::TelemetryOptions options,
                    crcl_server::CrclServerOptions own = {}) {
    if (server_) server_->stop();
    server_.reset();
    ports_.set(nullptr);
    robot_.reset();
    cell_ = std::make_unique<FakeCell>();
    own.listener.port = 0;
    own.listener.endpoint = kCrclEndpoint;
    robot_ = std::make_shared<crcl_server::CrclServer>(own, *cell_, *cell_);
    ASSERT_TRUE(robot_->start());
    options.listener.port = 0;
    ports_.set(robot_);
    options.robots = &ports_;
    server_ = std::make_unique<grpc_server::TelemetryServer>(options, *cell_, *cell_);
    const auto port = server_->start();
    ASSERT_TRUE(port) << port.error().message;
    port_ = *port;
    channel_ = new_channel();
    stub_ = pb::RobotService::NewStub(channel_);
  }

  static pb::SessionOptions fanuc() {
    pb::SessionOptions options;
    options.set_robot("fanuc");
    return options;
  }

  /// One session, from the client's side.
  struct Session {
    explicit Session(pb::RobotService::Stub& stub, const pb::SessionOptions& options = fanuc()) {
      set_deadline(context, 20s);
      stream = stub.Connect(&context);
      *request.mutable_options() = options;
      stream->Write(request);
    }
    ~Session() {
      context.TryCancel();
      if (!finished) (void)stream->Finish();
    }
    pb::Command& next(std::int64_t id) {
      request.Clear();
      pb::Command& command = *request.mutable_command()->mutable_command();
      command.set_command_id(id);
      return command;
    }
    bool send() { return stream->Write(request); }
    /// Sends a GetStatus and reads the next status.
    pb::Status status() {
      next(1).mutable_get_status();
      EXPECT_TRUE(send());
      return read();
    }
    pb::Status read() {
      pb::ConnectResponse response;
      EXPECT_TRUE(stream->Read(&response));
      return response.status();
    }
    grpc::Status end() {
      finished = true;
      pb::ConnectResponse response;
      while (stream->Read(&response)) continue;
      return stream->Finish();
    }

    grpc::ClientContext context;
    std::unique_ptr<grpc::ClientReaderWriter<pb::ConnectRequest, pb::ConnectResponse>> stream;
    pb::ConnectRequest request;
    bool finished = false;
  };

  void initialize(Session& session) {
    session.next(4).mutable_init_canon();
    ASSERT_TRUE(session.send());
    ASSERT_TRUE(cell_->wait_for_commands(1));
    cell_->report(0, 1, ActionState::kDone);
    const pb::CommandStatus status = session.status().command_status();
    ASSERT_EQ(status.command_id(), 4);
    ASSERT_EQ(status.command_state(), pb::COMMAND_STATE_DONE);
  }

  pb::Status unary_status(const pb::SessionOptions& options = fanuc()) {
    grpc::ClientContext context;
    set_deadline(context, 10s);
    pb::GetStatusRequest request;
    *request.mutable_options() = options;
    pb::GetStatusResponse response;
    const grpc::Status status = stub_->GetStatus(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.status();
  }

  std::shared_ptr<crcl_server::CrclServer> robot_;
  OnePort ports_;
  std::unique_ptr<pb::RobotService::Stub> stub_;
};

TEST_F(RobotService, ASessionIsAsAConnection) {
  Session session(*stub_);
  EXPECT_EQ(session.status().command_status().command_id(), -1);
  initialize(session);
  pb::Command& dwell = session.next(5);
  dwell.mutable_dwell()->set_dwell_time_s(0.5);
  ASSERT_TRUE(session.send());
  pb::CommandStatus status = session.status().command_status();
  EXPECT_EQ(status.command_id(), 5);
  EXPECT_EQ(status.name(), "DwellType");
  EXPECT_EQ(status.command_state(), pb::COMMAND_STATE_WORKING);
  cell_->report(0, 2, ActionState::kDone);
  EXPECT_EQ(session.status().command_status().command_state(), pb::COMMAND_STATE_DONE);
  // In the queue it stands as a command of the port.
  const api::Command command = cell_->commands().at(1);
  EXPECT_EQ(command.endpoint, kCrclEndpoint);
  EXPECT_EQ(std::get<api::Dwell>(std::get<api::RobotCommand>(command.body).action).duration, 500ms);
}

TEST_F(RobotService, UnitsAreASessionsOwn) {
  Session inches(*stub_), other(*stub_);
  initialize(inches);
  inches.next(5).mutable_set_length_units()->set_unit_name(pb::LENGTH_UNIT_INCH);
  ASSERT_TRUE(inches.send());
  EXPECT_EQ(inches.status().settings_status().length_unit_name(), pb::LENGTH_UNIT_INCH);
  EXPECT_EQ(other.status().settings_status().length_unit_name(), pb::LENGTH_UNIT_MILLIMETER);
  // All share the latest command.
  EXPECT_EQ(other.status().command_status().command_id(), 5);
  pb::SessionOptions metres = fanuc();
  metres.set_length_unit(pb::LENGTH_UNIT_METER);
  metres.set_angle_unit(pb::ANGLE_UNIT_RADIAN);
  const pb::SettingsStatus settings = unary_status(metres).settings_status();
  EXPECT_EQ(settings.length_unit_name(), pb::LENGTH_UNIT_METER);
  EXPECT_EQ(settings.angle_unit_name(), pb::ANGLE_UNIT_RADIAN);
}

TEST_F(RobotService, EveryGetStatusIsAnsweredOnceInOrder) {
  Session session(*stub_);
  constexpr int kMany = 500;
  std::thread sender([&] {
    for (int i = 0; i < kMany; ++i) {
      session.next(1).mutable_get_status();
      if (!session.send()) return;
    }
    session.stream->WritesDone();
  });
  std::int64_t last = 0;
  for (int i = 0; i < kMany; ++i) {
    const std::int64_t id = session.read().command_status().status_id();
    EXPECT_GT(id, last);
    last = id;
  }
  sender.join();
  const grpc::Status status = session.end();
  EXPECT_TRUE(status.ok()) << status.error_message();
}

TEST_F(RobotService, ReportsErrorsByIdAsThePortDoes) {
  Session session(*stub_);
  initialize(session);
  pb::Pose& pose = *session.next(9).mutable_move_to()->mutable_end_position();
  pose.mutable_point()->set_x(1);
  ASSERT_TRUE(session.send());
  const pb::CommandStatus status = session.status().command_status();
  EXPECT_EQ(status.command_id(), 9);
  EXPECT_EQ(status.command_state(), pb::COMMAND_STATE_ERROR);
  EXPECT_NE(status.state_description().find("MoveToType/EndPosition/Point/Y"), std::string::npos)
      << status.state_description();
}

TEST_F(RobotService, AnUnknownCommandStopsTheRobotAndEndsTheSessionAsOnThePort) {
  Session session(*stub_);
  initialize(session);
  session.next(5);  // of no kind
  ASSERT_TRUE(session.send());
  EXPECT_EQ(session.end().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  ASSERT_TRUE(cell_->wait_for_commands(2));
  const auto stop = std::get<api::RobotCommand>(cell_->commands().at(1).body);
  EXPECT_TRUE(std::holds_alternative<api::StopMotion>(stop.action));
  const pb::CommandStatus status = unary_status().command_status();
  EXPECT_EQ(status.command_id(), 4);
  EXPECT_EQ(status.command_state(), pb::COMMAND_STATE_ERROR);
}

TEST_F(RobotService, ProgramsRun) {
  Session session(*stub_);
  pb::Program& program = *session.request.mutable_program();
  program.mutable_init_canon()->set_command_id(1);
  pb::Command& dwell = *program.add_middle_commands();
  dwell.set_command_id(2);
  dwell.mutable_dwell()->set_dwell_time_s(1);
  program.mutable_end_canon()->set_command_id(3);
  ASSERT_TRUE(session.send());
  for (api::Ticket ticket = 1; ticket <= 3; ++ticket) {
    ASSERT_TRUE(cell_->wait_for_commands(ticket));
    cell_->report(0, ticket, ActionState::kDone);
  }
  EXPECT_TRUE(eventually([&] {
    const pb::CommandStatus status = session.status().command_status();
    return status.command_id() == 3 && status.command_state() == pb::COMMAND_STATE_DONE;
  }));
}

TEST_F(RobotService, ASessionBeginsWithItsRobot) {
  pb::SessionOptions nobody;
  nobody.set_robot("nobody");
  Session unknown(*stub_, nobody);
  const grpc::Status not_found = unknown.end();
  EXPECT_EQ(not_found.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_NE(not_found.error_message().find("fanuc"), std::string::npos);
  Session twice(*stub_);
  twice.request.Clear();
  *twice.request.mutable_options() = fanuc();
  twice.send();
  EXPECT_EQ(twice.end().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(RobotService, ExecuteAnswersWhenTheCommandIsOver) {
  const auto execute = [this](pb::Command command) {
    return std::async(std::launch::async, [this, command = std::move(command)] {
      grpc::ClientContext context;
      set_deadline(context, 20s);
      pb::ExecuteRequest request;
      *request.mutable_options() = fanuc();
      *request.mutable_command()->mutable_command() = command;
      pb::ExecuteResponse response;
      const grpc::Status status = stub_->Execute(&context, request, &response);
      EXPECT_TRUE(status.ok()) << status.error_message();
      return response;
    });
  };
  pb::Command command;
  command.set_command_id(4);
  command.mutable_init_canon();
  auto init = execute(command);
  ASSERT_TRUE(cell_->wait_for_commands(1));
  EXPECT_EQ(init.wait_for(50ms), std::future_status::timeout);
  cell_->report(0, 1, ActionState::kDone);
  EXPECT_EQ(init.get().status().command_status().command_state(), pb::COMMAND_STATE_DONE);
  command.set_command_id(5);
  command.mutable_dwell()->set_dwell_time_s(100);
  auto dwell = execute(command);
  ASSERT_TRUE(cell_->wait_for_commands(2));
  cell_->report(0, 2, ActionState::kWorking);
  command.set_command_id(6);
  command.mutable_stop_motion()->set_stop_condition(pb::STOP_CONDITION_FAST);
  auto stop = execute(command);
  ASSERT_TRUE(cell_->wait_for_commands(3));
  const pb::ExecuteResponse replaced = dwell.get();
  EXPECT_TRUE(replaced.replaced());
  EXPECT_EQ(replaced.status().command_status().command_id(), 6);
  cell_->report(0, 3, ActionState::kDone);
  EXPECT_FALSE(stop.get().replaced());
  // A refusal of the robot is no error of the call.
  command.set_command_id(7);
  command.mutable_dwell()->set_dwell_time_s(-1);
  const pb::CommandStatus refused = execute(command).get().status().command_status();
  EXPECT_EQ(refused.command_state(), pb::COMMAND_STATE_ERROR);
  EXPECT_EQ(refused.command_id(), 7);
}

TEST_F(RobotService, StreamsStatuses) {
  grpc::ClientContext context;
  set_deadline(context, 20s);
  pb::StreamStatusRequest request;
  *request.mutable_options() = fanuc();
  request.set_rate_hz(200);
  request.mutable_report()->set_report_pose_status(true);
  const auto stream = stub_->StreamStatus(&context, request);
  pb::StreamStatusResponse response;
  std::int64_t last = 0;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(stream->Read(&response));
    EXPECT_GT(response.status().command_status().status_id(), last);
    last = response.status().command_status().status_id();
    EXPECT_TRUE(response.status().has_pose_status());
    EXPECT_FALSE(response.status().has_joint_statuses());
  }
  context.TryCancel();
  (void)stream->Finish();

  grpc::ClientContext refused;
  request.set_rate_hz(1e6);
  const auto none = stub_->StreamStatus(&refused, request);
  EXPECT_FALSE(none->Read(&response));
  EXPECT_EQ(none->Finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(RobotService, TheRobotsEndEndsItsSessions) {
  Session session(*stub_);
  (void)session.status();
  robot_->stop();
  EXPECT_EQ(session.end().error_code(), grpc::StatusCode::UNAVAILABLE);
  Session late(*stub_);
  EXPECT_EQ(late.end().error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(RobotService, ThereAreAsManySessionsAsPlaces) {
  crcl_server::CrclServerOptions two;
  two.listener.limits.at_once = 2;
  start_robots({}, two);
  auto first = std::make_unique<Session>(*stub_);
  Session second(*stub_);
  (void)first->status();
  (void)second.status();
  Session third(*stub_);
  EXPECT_EQ(third.end().error_code(), grpc::StatusCode::UNAVAILABLE);
  first.reset();
  EXPECT_TRUE(eventually([&] {
    Session again(*stub_);
    again.next(1).mutable_get_status();
    pb::ConnectResponse response;
    return again.send() && again.stream->Read(&response);
  }));
}

TEST_F(RobotService, GivesReadersTheStateOnly) {
  grpc_server::TelemetryOptions options;
  options.listener.access =
      std::make_shared<protocols::Access>(protocols::AccessRules{.local = protocols::Role::kView});
  start_robots(options);
  Session session(*stub_);
  EXPECT_EQ(session.end().error_code(), grpc::StatusCode::PERMISSION_DENIED);
  grpc::ClientContext context;
  set_deadline(context, 10s);
  pb::ExecuteRequest request;
  *request.mutable_options() = fanuc();
  request.mutable_command()->mutable_command()->mutable_init_canon();
  pb::ExecuteResponse response;
  EXPECT_EQ(stub_->Execute(&context, request, &response).error_code(),
            grpc::StatusCode::PERMISSION_DENIED);
  EXPECT_TRUE(cell_->commands().empty());
  EXPECT_EQ(unary_status().command_status().command_id(), -1);
}

}  // namespace
}  // namespace aprsim::test
