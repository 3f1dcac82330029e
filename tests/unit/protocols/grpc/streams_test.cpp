// Streams that must not miss anything: every step, and events.

#include <set>
#include <thread>

#include "tests/unit/protocols/grpc/telemetry_fixture.hpp"
#include "world/runtime/publish/event_log.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

class Steps : public TelemetryFixture {
 protected:
  ~Steps() override { server_.reset(); }

  void begin(grpc_server::TelemetryOptions options = {}, int more_gears = 0) {
    options.feed = &feed_;
    start(std::move(options), more_gears);
    if (cell_) next_ = cell_->latest();
  }
  /// Publishes so many steps.
  void step(int count) {
    for (; count > 0; --count) {
      auto snapshot = std::make_shared<api::Snapshot>(*next_);
      ++snapshot->step;
      next_ = snapshot;
      feed_.publish(next_);
    }
  }
  using Reader = std::unique_ptr<grpc::ClientReader<v1::StreamSnapshotsResponse>>;
  /// A stream whose first sample has come.
  Reader open(v1::TelemetryService::Stub& stub, grpc::ClientContext& context,
              v1::StreamSnapshotsResponse& response, v1::StreamSnapshotsRequest request = {}) {
    request.set_every_step(true);
    auto reader = stub.StreamSnapshots(&context, request);
    // The server follows the cell once the call has come: steps until then are not for it.
    std::atomic<bool> there = false;
    std::jthread stepper([&] {
      while (!there) {
        step(1);
        std::this_thread::sleep_for(1ms);
      }
    });
    EXPECT_TRUE(reader->Read(&response));
    there = true;
    return reader;
  }

  api::SnapshotFollowers feed_;
  api::SnapshotPtr next_;
};

TEST_F(Steps, ComeAllInTheirOrder) {
  begin();
  grpc::ClientContext context;
  v1::StreamSnapshotsResponse response;
  const auto reader = open(*telemetry_, context, response);
  EXPECT_EQ(response.effective_rate_hz(), 0);
  EXPECT_EQ(response.sequence(), 1u);
  EXPECT_EQ(response.snapshot().robots_size(), 1);
  std::uint64_t last = response.snapshot().step(), sequence = 1;
  for (int burst = 0; burst < 20; ++burst) {
    step(200);
    while (last < next_->step) {
      ASSERT_TRUE(reader->Read(&response));
      ASSERT_EQ(response.snapshot().step(), last + 1);
      ASSERT_EQ(response.sequence(), ++sequence);
      ASSERT_EQ(response.dropped_count(), 0u);
      last = response.snapshot().step();
    }
  }
  context.TryCancel();
}

TEST_F(Steps, TellChangesOfACellThatStandsAndNoneTwiceOfOneThatRuns) {
  begin();
  grpc::ClientContext context;
  v1::StreamSnapshotsResponse response;
  const auto reader = open(*telemetry_, context, response);
  // Drain what has been stepped until then.
  while (response.snapshot().step() < next_->step) ASSERT_TRUE(reader->Read(&response));
  const auto publish = [&](std::uint64_t steps, bool paused, api::Ticket applied) {
    auto snapshot = std::make_shared<api::Snapshot>(*next_);
    snapshot->step += steps;
    snapshot->paused = paused;
    snapshot->applied = applied;
    next_ = snapshot;
    feed_.publish(next_);
  };
  publish(0, false, 1);  // a command between two steps: seen with the next one
  publish(1, false, 2);
  publish(0, true, 3);
  publish(0, true, 4);
  std::vector<std::uint64_t> tickets;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(reader->Read(&response));
    tickets.push_back(response.snapshot().applied_ticket());
  }
  EXPECT_EQ(tickets, (std::vector<std::uint64_t>{2, 3, 4}));
  context.TryCancel();
}

TEST_F(Steps, EndTheStreamOfASlowReaderOnly) {
  begin({.max_backlog_samples = 500, .write_timeout = 10s}, 300);  // some 40 kB a sample
  grpc::ClientContext slow_context, quick_context;
  v1::StreamSnapshotsResponse response;
  const auto slow = open(*telemetry_, slow_context, response);
  const auto other = v1::TelemetryService::NewStub(new_channel());
  v1::StreamSnapshotsRequest request;
  request.mutable_read_mask()->add_paths("step");
  const auto quick = open(*other, quick_context, response, request);
  std::uint64_t last = response.snapshot().step();
  // The quick one gets everything, the other reads nothing.
  for (int i = 0; i < 40; ++i) {
    step(50);
    while (last < next_->step) {
      ASSERT_TRUE(quick->Read(&response));
      ASSERT_EQ(response.snapshot().step(), ++last);
      ASSERT_EQ(response.snapshot().robots_size(), 0);
    }
  }
  EXPECT_GE(server_->stats().dropped, 100u);
  std::uint64_t before = 0;
  while (slow->Read(&response)) {
    if (before != 0) {
      ASSERT_EQ(response.snapshot().step(), before + 1);
    }
    before = response.snapshot().step();
  }
  const auto status = slow->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << status.error_message();
  EXPECT_NE(status.error_message().find("behind"), std::string::npos);
  quick_context.TryCancel();
}

TEST_F(Steps, TooManyForTheServerEndTheStreams) {
  begin({}, 300);
  grpc::ClientContext context;
  v1::StreamSnapshotsResponse response;
  const auto reader = open(*telemetry_, context, response);
  std::atomic<bool> ended = false;
  std::jthread stepper([&] {
    while (!ended) step(200);
  });
  while (reader->Read(&response)) continue;
  ended = true;
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(Steps, HaveNoRate) {
  begin();
  v1::StreamSnapshotsRequest request;
  request.set_every_step(true);
  request.set_rate_hz(10);
  grpc::ClientContext context;
  const auto reader = telemetry_->StreamSnapshots(&context, request);
  v1::StreamSnapshotsResponse response;
  EXPECT_FALSE(reader->Read(&response));
  const auto status = reader->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_NE(status.error_message().find("rate_hz"), std::string::npos);
}

class EventsOfTheCell : public TelemetryFixture {
 protected:
  ~EventsOfTheCell() override { server_.reset(); }

  void begin(std::size_t capacity = 100, grpc_server::TelemetryOptions options = {}) {
    log_ = std::make_unique<world::EventLog>(capacity);
    options.events = log_.get();
    start(std::move(options));
  }
  void happen(api::CellEventKind kind, std::vector<std::string> names = {}, int count = 1) {
    std::vector<api::CellEventPtr> events;
    for (; count > 0; --count) {
      events.push_back(std::make_shared<const api::CellEvent>(api::CellEvent{.sequence = ++last_,
                                                                             .epoch = 1,
                                                                             .step = 10 * last_,
                                                                             .time = 10ms * last_,
                                                                             .kind = kind,
                                                                             .names = names,
                                                                             .text = "text",
                                                                             .robot = 1,
                                                                             .number = 5}));
    }
    log_->add(std::move(events));
  }
  /// The numbers of those that are kept and wanted.
  std::vector<std::uint64_t> past(v1::StreamEventsRequest request,
                                  grpc::StatusCode expected = grpc::StatusCode::OK) {
    request.set_past_only(true);
    grpc::ClientContext context;
    set_deadline(context, 20s);
    const auto reader = telemetry_->StreamEvents(&context, request);
    std::vector<std::uint64_t> numbers;
    v1::StreamEventsResponse response;
    while (reader->Read(&response)) numbers.push_back(response.event().sequence());
    const auto status = reader->Finish();
    EXPECT_EQ(status.error_code(), expected) << status.error_message();
    message_ = status.error_message();
    return numbers;
  }
  static v1::StreamEventsRequest after(std::uint64_t number) {
    v1::StreamEventsRequest request;
    request.set_after(number);
    return request;
  }

  std::unique_ptr<world::EventLog> log_;
  std::uint64_t last_ = 0;
  std::string message_;
};

using Numbers = std::vector<std::uint64_t>;
using HappenedKind = api::CellEventKind;

TEST_F(EventsOfTheCell, ComeAsTheyHappenWithAllThatTheySay) {
  begin();
  happen(HappenedKind::kLost);
  grpc::ClientContext context;
  set_deadline(context, 30s);
  const auto reader = telemetry_->StreamEvents(&context, {});
  reader->WaitForInitialMetadata();  // from now on
  happen(HappenedKind::kGrasped, {"fanuc", "gear_1"});
  v1::StreamEventsResponse response;
  ASSERT_TRUE(reader->Read(&response));
  const v1::CellEvent& event = response.event();
  EXPECT_EQ(event.sequence(), 2u);
  EXPECT_EQ(event.epoch(), 1u);
  EXPECT_EQ(event.step(), 20u);
  EXPECT_EQ(event.sim_time().nanos(), 20'000'000);
  EXPECT_EQ(event.kind(), v1::CELL_EVENT_KIND_GRASPED);
  EXPECT_EQ(event.names(1), "gear_1");
  EXPECT_EQ(event.text(), "text");
  EXPECT_EQ(event.robot(), 1u);
  EXPECT_EQ(event.number(), 5u);
  EXPECT_EQ(response.lost(), 0u);
  happen(HappenedKind::kReleased, {}, 60);
  for (std::uint64_t next = 3; next <= 62; ++next) {
    ASSERT_TRUE(reader->Read(&response));
    EXPECT_EQ(response.event().sequence(), next);
  }
  context.TryCancel();
}

TEST_F(EventsOfTheCell, AreFoundByKindAndName) {
  begin();
  happen(HappenedKind::kGrasped, {"fanuc", "gear_1"});
  happen(HappenedKind::kContactBegun, {"motoman", "gear_1"});
  happen(HappenedKind::kReleased, {"fanuc", "gear_1"});
  happen(HappenedKind::kGrasped, {"motoman", "gear_2"});
  EXPECT_EQ(past(after(0)), (Numbers{1, 2, 3, 4}));
  EXPECT_EQ(past(after(2)), (Numbers{3, 4}));
  auto request = after(0);
  request.add_kinds(v1::CELL_EVENT_KIND_GRASPED);
  EXPECT_EQ(past(request), (Numbers{1, 4}));
  request.add_kinds(v1::CELL_EVENT_KIND_RELEASED);
  request.add_names("fanuc");
  EXPECT_EQ(past(request), (Numbers{1, 3}));
  request.add_names("gear_2");
  EXPECT_EQ(past(request), (Numbers{1, 3, 4}));
}

TEST_F(EventsOfTheCell, ThatAreGoneAreOutOfRangeOrCounted) {
  begin(10);
  happen(HappenedKind::kGrasped, {"fanuc"}, 24);
  happen(HappenedKind::kReleased, {"fanuc"});
  EXPECT_EQ(past(after(14), grpc::StatusCode::OUT_OF_RANGE), Numbers{});
  EXPECT_NE(message_.find("up to 15"), std::string::npos) << message_;
  EXPECT_EQ(past(after(15)).size(), 10u);
  EXPECT_EQ(past(after(26), grpc::StatusCode::OUT_OF_RANGE), Numbers{});
  EXPECT_NE(message_.find("anew with the daemon"), std::string::npos) << message_;

  auto request = after(3);
  request.set_allow_gap(true);
  request.add_kinds(v1::CELL_EVENT_KIND_RELEASED);
  request.set_past_only(true);
  grpc::ClientContext context;
  set_deadline(context, 20s);
  const auto reader = telemetry_->StreamEvents(&context, request);
  v1::StreamEventsResponse response;
  ASSERT_TRUE(reader->Read(&response));
  EXPECT_EQ(response.event().sequence(), 25u);
  EXPECT_EQ(response.lost(), 12u);
  EXPECT_FALSE(reader->Read(&response));
}

TEST_F(EventsOfTheCell, RefuseUnknownKinds) {
  begin();
  auto request = after(0);
  request.add_kinds(static_cast<v1::CellEventKind>(99));
  EXPECT_EQ(past(request, grpc::StatusCode::INVALID_ARGUMENT), Numbers{});
  EXPECT_NE(message_.find("kinds: 99"), std::string::npos) << message_;
}

TEST_F(EventsOfTheCell, ComeAfterASilenceThatIsLongerThanAWriteMayTake) {
  grpc_server::TelemetryOptions options;
  options.write_timeout = 50ms;
  begin(100, std::move(options));
  grpc::ClientContext context;
  set_deadline(context, 30s);
  const auto reader = telemetry_->StreamEvents(&context, {});
  reader->WaitForInitialMetadata();
  v1::StreamEventsResponse response;
  for (std::uint64_t i = 1; i <= 3; ++i) {
    happen(HappenedKind::kGrasped);
    ASSERT_TRUE(reader->Read(&response)) << reader->Finish().error_message();
    EXPECT_EQ(response.event().sequence(), i);
    // Long enough for the stream to be ended if it counted as stuck.
    std::this_thread::sleep_for(500ms);
  }
  context.TryCancel();
}

TEST_F(EventsOfTheCell, EndWithTheServer) {
  begin();
  grpc::ClientContext context;
  const auto reader = telemetry_->StreamEvents(&context, {});
  reader->WaitForInitialMetadata();
  server_->stop();
  v1::StreamEventsResponse response;
  EXPECT_FALSE(reader->Read(&response));
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
}

}  // namespace
}  // namespace aprsim::test
