#include <grpcpp/impl/codegen/client_unary_call.h>
#include <grpcpp/impl/codegen/sync_stream.h>
#include <grpcpp/support/byte_buffer.h>

#include "tests/support/access_with.hpp"
#include "tests/support/tcp_socket.hpp"
#include "tests/unit/protocols/grpc/telemetry_fixture.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;
using Serving = TelemetryFixture;

grpc::ByteBuffer bytes(const std::string& text) {
  const grpc::Slice slice(text);
  return {&slice, 1};
}

std::string text(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  if (!buffer.Dump(&slices).ok()) return {};
  std::string out;
  for (const auto& slice : slices) {
    out.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return out;
}

/// grpc.health.v1.Health/Check: service name in field 1, status in field 1.
std::string health(const std::shared_ptr<grpc::Channel>& channel, const std::string& service) {
  const grpc::internal::RpcMethod method("/grpc.health.v1.Health/Check",
                                         grpc::internal::RpcMethod::NORMAL_RPC);
  std::string request;
  if (!service.empty())
    request = "\x0a" + std::string(1, static_cast<char>(service.size())) + service;
  grpc::ClientContext context;
  grpc::ByteBuffer response;
  const auto status = grpc::internal::BlockingUnaryCall<grpc::ByteBuffer, grpc::ByteBuffer>(
      channel.get(), method, &context, bytes(request), &response);
  if (!status.ok())
    return status.error_code() == grpc::StatusCode::NOT_FOUND ? "not found" : "error";
  const std::string answer = text(response);
  if (answer == "\x08\x01") return "serving";
  return answer == "\x08\x02" ? "not serving" : "odd answer";
}

bool answers(const std::shared_ptr<grpc::Channel>& channel) {
  grpc::ClientContext context;
  v1::GetCellResponse response;
  return v1::TelemetryService::NewStub(channel)->GetCell(&context, {}, &response).ok();
}

TEST_F(Serving, HealthServesAllNamesAndFollowsTheWorld) {
  start();
  EXPECT_EQ(health(channel_, ""), "serving");
  EXPECT_EQ(health(channel_, "aprsim.v1.TelemetryService"), "serving");
  for (const char* service : {"aprsim.v1.ControlService", "aprsim.v1.HistoryService",
                              "aprsim.v1.JournalService", "aprsim.crcl.v1.RobotService"}) {
    EXPECT_EQ(health(channel_, service), "serving") << service;
  }
  EXPECT_EQ(health(channel_, "aprsim.v1.NoService"), "not found");
  cell_->publish([](auto& s) { s.world_fault = "gear_1 left the cell"; });
  EXPECT_TRUE(eventually([&] { return health(channel_, "") == "not serving"; }));
  cell_->publish([](auto& s) { s.world_fault.clear(); });
  EXPECT_TRUE(eventually([&] { return health(channel_, "") == "serving"; }));
  // Every other reason that keeps the simulation from running is reported.
  cell_->complain("the pace is 0.11 instead of 1");
  EXPECT_TRUE(eventually([&] { return health(channel_, "") == "not serving"; }));
  grpc::ClientContext context;
  v1::GetSnapshotResponse response;
  ASSERT_TRUE(telemetry_->GetSnapshot(&context, {}, &response).ok());
  EXPECT_EQ(response.problem(), "the pace is 0.11 instead of 1");
  cell_->complain("");
  EXPECT_TRUE(eventually([&] { return health(channel_, "") == "serving"; }));
}

TEST_F(Serving, ReflectionListsTheServices) {
  start();
  const grpc::internal::RpcMethod method(
      "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
      grpc::internal::RpcMethod::BIDI_STREAMING);
  grpc::ClientContext context;
  set_deadline(context, 10s);
  const std::unique_ptr<grpc::ClientReaderWriter<grpc::ByteBuffer, grpc::ByteBuffer>> stream(
      grpc::internal::ClientReaderWriterFactory<grpc::ByteBuffer, grpc::ByteBuffer>::Create(
          channel_.get(), method, &context));
  // ServerReflectionRequest.list_services is field 7.
  ASSERT_TRUE(stream->Write(bytes("\x3a\x01*")));
  grpc::ByteBuffer response;
  ASSERT_TRUE(stream->Read(&response));
  const std::string answer = text(response);
  for (const char* name : {"aprsim.v1.TelemetryService", "aprsim.v1.ControlService",
                           "grpc.health.v1.Health", "grpc.reflection.v1alpha.ServerReflection"}) {
    EXPECT_NE(answer.find(name), std::string::npos) << name;
  }
  context.TryCancel();
}

TEST_F(Serving, StopEndsStreamsAndWaitingCalls) {
  start({.max_streams = 8, .write_timeout = 60s}, 300);
  cell_->hold();
  grpc::Status waiting;
  std::jthread waiter([&] {
    grpc::ClientContext context;
    set_deadline(context, 60s);
    v1::PauseResponse response;
    waiting = control_->Pause(&context, {}, &response);
  });
  // Some read, some never do.
  v1::StreamSnapshotsRequest request;
  request.set_rate_hz(1000);
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::StreamSnapshotsResponse>>> readers;
  for (int i = 0; i < 8; ++i) {
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    readers.push_back(telemetry_->StreamSnapshots(contexts.back().get(), request));
  }
  v1::StreamSnapshotsResponse response;
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(readers[static_cast<std::size_t>(i)]->Read(&response));
  ASSERT_TRUE(eventually([&] { return !cell_->commands().empty(); }));

  const auto begin = steady_clock::now();
  server_->stop(500ms);
  EXPECT_LT(steady_clock::now() - begin, 20s) << "it waits neither for readers nor for calls";
  waiter.join();
  EXPECT_EQ(waiting.error_code(), grpc::StatusCode::UNAVAILABLE);
  for (auto& reader : readers) {
    while (reader->Read(&response)) {
    }
    EXPECT_FALSE(reader->Finish().ok());
  }
}

TEST_F(Serving, PortInUseIsOneClearError) {
  start();
  grpc_server::TelemetryServer second({.listener = {.port = port_}}, *cell_, *cell_);
  const auto result = second.start();
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().field, "grpc.port");
  EXPECT_NE(result.error().message.find("Address already in use"), std::string::npos);
  EXPECT_NE(result.error().message.find(std::to_string(port_)), std::string::npos);
}

TEST_F(Serving, BadOptionsAreNamed) {
  FakeCell cell;
  grpc_server::TelemetryServer bad_address({.listener = {.address = "cell.lab"}}, cell, cell);
  EXPECT_EQ(bad_address.start().error().field, "grpc.address");
  grpc_server::TelemetryServer bad_rate({.listener = {}, .default_rate_hz = 2000}, cell, cell);
  EXPECT_EQ(bad_rate.start().error().field, "grpc.default_rate_hz");
}

TEST_F(Serving, PortIsFreeAgainAfterStop) {
  start();
  server_->stop();
  grpc_server::TelemetryServer second({.listener = {.port = port_}}, *cell_, *cell_);
  const auto result = second.start();
  ASSERT_TRUE(result.has_value()) << result.error().message;
  EXPECT_EQ(*result, port_);
}

TEST_F(Serving, ConnectionsBeyondTheLimitAreClosedAndRoomComesBack) {
  start({.listener = {.limits = {.at_once = 2}}});
  {
    const auto first = new_channel(), second = new_channel();
    EXPECT_TRUE(answers(first));
    EXPECT_TRUE(answers(second));
    TcpSocket third(port_);
    EXPECT_TRUE(third.ended());
    EXPECT_EQ(server_->stats().open, 2U);
  }
  EXPECT_TRUE(eventually([&] { return server_->stats().open == 0; }));
  EXPECT_TRUE(eventually([&] { return answers(new_channel()); }));
}

TEST_F(Serving, IdleConnectionsGiveWayToANewcomer) {
  start({.listener = {.limits = {.at_once = 3}}});
  std::vector<TcpSocket> idle;
  for (int i = 0; i < 3; ++i) idle.emplace_back(port_);
  EXPECT_TRUE(eventually([&] { return server_->stats().open == 3; }));
  const auto client = new_channel();
  EXPECT_TRUE(eventually([&] { return answers(client); }));
  EXPECT_TRUE(idle[0].ended());
}

TEST_F(Serving, ATableFullOfOneAddressHasAPlaceForAnother) {
  start({.listener = {.limits = {.at_once = 2}}});
  const auto first = new_channel(), second = new_channel();
  EXPECT_TRUE(answers(first));
  EXPECT_TRUE(answers(second));
  TcpSocket same(port_);
  EXPECT_TRUE(same.ended());
  // The place that is kept, and then one of the address that has most.
  for (const char* address : {"127.0.0.2", "127.0.0.3"}) {
    TcpSocket newcomer(port_, 0, address);
    EXPECT_FALSE(newcomer.receive(TcpSocket::Clock::now() + 10s).empty()) << address;
  }
}

/// How a pause ends that comes with this metadata.
grpc::Status pause_with(v1::ControlService::Stub& control, const std::string& authorization) {
  grpc::ClientContext context;
  if (!authorization.empty()) context.AddMetadata("authorization", authorization);
  v1::PauseResponse response;
  return control.Pause(&context, {}, &response);
}

TEST_F(Serving, CommandsNeedATokenWhenThereIsOneReadingDoesNot) {
  start({.listener = {.access = access_with_tokens()}});
  for (const char* wrong :
       {"", "right-token", "Basic right-token", "Bearer wrong-token", "Bearer right-token2"}) {
    const auto status = pause_with(*control_, wrong);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAUTHENTICATED) << wrong;
    EXPECT_EQ(status.error_message().find("right-token"), std::string::npos);
  }
  v1::StepResponse stepped;
  grpc::ClientContext step;
  EXPECT_EQ(control_->Step(&step, {}, &stepped).error_code(), grpc::StatusCode::UNAUTHENTICATED);
  EXPECT_TRUE(cell_->commands().empty());
  EXPECT_TRUE(answers(channel_));
  EXPECT_TRUE(pause_with(*control_, "Bearer right-token").ok());
  EXPECT_EQ(cell_->commands().size(), 1U);
}

TEST_F(Serving, TokensCannotBeTriedOften) {
  const auto access = access_with_tokens();
  start({.listener = {.access = access}});
  auto answer = grpc::StatusCode::OK;
  int wrong = 0;
  EXPECT_TRUE(eventually(
      [&] {
        answer = pause_with(*control_, "Bearer guess").error_code();
        wrong += answer == grpc::StatusCode::UNAUTHENTICATED ? 1 : 0;
        return answer != grpc::StatusCode::UNAUTHENTICATED;
      },
      std::chrono::seconds(60)));
  EXPECT_EQ(answer, grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_GE(wrong, 5);
  // However slow the calls are: as if an hour of further guesses had gone by.
  using protocols::Access;
  const auto later = Access::Clock::now() + std::chrono::hours(1);
  while (access->identify("127.0.0.1", {.token = "guess"}, {}, later).problem ==
         protocols::Caller::Problem::kWrongToken) {
  }
  EXPECT_TRUE(cell_->commands().empty());
  // A right token is never limited.
  EXPECT_EQ(pause_with(*control_, "Bearer right-token").error_code(), grpc::StatusCode::OK);
}

TEST_F(Serving, NobodyCommandsWhereNobodyMay) {
  start({.listener = {.access = std::make_shared<protocols::Access>(
                          protocols::AccessRules{.local = protocols::Role::kView})}});
  EXPECT_EQ(pause_with(*control_, "").error_code(), grpc::StatusCode::PERMISSION_DENIED);
  for (const char* authorization : {"Bearer ", "Bearer anything"}) {
    EXPECT_EQ(pause_with(*control_, authorization).error_code(), grpc::StatusCode::UNAUTHENTICATED);
  }
  EXPECT_TRUE(cell_->commands().empty());
  EXPECT_TRUE(answers(channel_));
}

TEST_F(Serving, OversizedRequestIsRefused) {
  start();
  v1::GetSnapshotRequest request;
  request.mutable_read_mask()->add_paths(std::string(2'000'000, 'x'));
  grpc::ClientContext context;
  v1::GetSnapshotResponse response;
  EXPECT_EQ(telemetry_->GetSnapshot(&context, request, &response).error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
}

}  // namespace
}  // namespace aprsim::test
