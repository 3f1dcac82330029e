// Viewers' requests to inject faults, and the fault list that viewers receive.
#include "tests/unit/protocols/web/web_fixture.hpp"
#include "world/api/faults/fault_kinds.hpp"

namespace aprsim {
namespace {

using test::RawWebClient;
using FaultRequest = test::WebFixture;

v1::ViewerRequest leak() {
  v1::ViewerRequest request;
  auto& fault = *request.mutable_inject_fault();
  fault.set_kind("gripper-leak");
  fault.set_target("fanuc");
  (*fault.mutable_parameters())["over"] = 5;
  fault.mutable_at()->set_seconds(12);
  fault.mutable_duration()->set_seconds(3);
  return request;
}

TEST_F(FaultRequest, ViewersAreToldEveryKindWithItsRanges) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  const auto told = client.next([](const auto& u) { return u.has_fault_kinds(); });
  ASSERT_TRUE(told);
  const auto& kinds = told->fault_kinds().kinds();
  ASSERT_EQ(kinds.size(), static_cast<int>(faults::kKinds));
  for (const auto& kind : faults::all_kinds()) {
    const auto& message = kinds[static_cast<int>(kind.kind)];
    EXPECT_EQ(message.name(), kind.name);
    EXPECT_EQ(message.target(), faults::pattern_of(kind.target));
    ASSERT_EQ(message.parameters_size(), static_cast<int>(kind.parameter_count()));
    for (std::size_t i = 0; i < kind.parameter_count(); ++i) {
      EXPECT_EQ(message.parameters(static_cast<int>(i)).unit(), kind.parameters[i].unit);
      EXPECT_EQ(message.parameters(static_cast<int>(i)).max(), kind.parameters[i].max);
    }
  }
  EXPECT_EQ(told->fault_kinds().quantities_size(),
            static_cast<int>(faults::all_quantities().size()));
}

TEST_F(FaultRequest, IsAnsweredOnceTheCellHasTakenIt) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  v1::ViewerRequest request = leak();
  request.set_id(77);
  client.send(request);
  ASSERT_TRUE(world.wait_for_commands(1));
  const auto fault =
      std::get<api::InjectFault>(std::get<api::FaultCommand>(world.commands()[0].body));
  EXPECT_EQ(fault.kind, "gripper-leak");
  EXPECT_EQ(fault.target, "fanuc");
  EXPECT_EQ(fault.parameters.at("over"), 5);
  EXPECT_EQ(std::get<api::AtTime>(fault.trigger).time, std::chrono::seconds(12));
  EXPECT_EQ(fault.duration, std::chrono::seconds(3));
  // The outcome must not overtake this snapshot, which comes before the command is applied.
  world.publish([](api::Snapshot& s) { s.conveyor.travel_m = 1; });
  const auto before = client.next([](const auto& u) {
    return u.has_outcome() || (u.has_snapshot() && u.snapshot().conveyor().travel_m() == 1);
  });
  ASSERT_TRUE(before && before->has_snapshot());
  world.apply();
  const auto outcome = client.next([](const auto& u) { return u.has_outcome(); });
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->outcome().id(), 77u);
  EXPECT_TRUE(outcome->outcome().ok());
}

TEST_F(FaultRequest, ReportsTheRefusalOfTheCell) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  v1::ViewerRequest end;
  end.set_id(3);
  end.mutable_end_fault()->set_id(9);
  client.send(end);
  ASSERT_TRUE(world.wait_for_commands(1));
  world.publish([](api::Snapshot& s) {
    s.applied = 1;
    s.failures =
        std::make_shared<const std::vector<api::CommandFailure>>(std::vector<api::CommandFailure>{
            {1, {ErrorCode::kNotFound, "id", "no fault 9 waits or lasts"}}});
  });
  const auto outcome = client.next([](const auto& u) { return u.has_outcome(); });
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome->outcome().id(), 3u);
  EXPECT_FALSE(outcome->outcome().ok());
  EXPECT_EQ(outcome->outcome().field(), "id");
  EXPECT_EQ(outcome->outcome().message(), "no fault 9 waits or lasts");
}

TEST_F(FaultRequest, RefusesInvalidRequestsAtOnce) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  v1::ViewerRequest request;
  request.mutable_inject_fault()->mutable_crossing()->set_quantity("mood");
  EXPECT_EQ(client.ask(request).field(), "crossing");
  EXPECT_TRUE(world.commands().empty());
}

TEST_F(FaultRequest, NeedsPermission) {
  options.control = false;
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  const auto outcome = client.ask(leak());
  EXPECT_EQ(outcome.field(), "permission");
  EXPECT_TRUE(world.commands().empty());
}

TEST_F(FaultRequest, AViewerThatLeavesIsNotAnswered) {
  start();
  {
    RawWebClient gone(port);
    (void)gone.upgrade();
    v1::ViewerRequest request = leak();
    request.set_id(1);
    gone.send(request);
    ASSERT_TRUE(world.wait_for_commands(1));
  }
  world.apply();
  RawWebClient client(port);
  (void)client.upgrade();
  EXPECT_TRUE(client.next([](const auto& u) { return u.has_snapshot(); }));
}

}  // namespace
}  // namespace aprsim
