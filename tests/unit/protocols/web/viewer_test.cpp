#include "tests/unit/protocols/web/web_fixture.hpp"

namespace aprsim {
namespace {

using test::RawWebClient;
using Viewer = test::WebFixture;

v1::ViewerRequest pause() {
  v1::ViewerRequest request;
  (void)request.mutable_pause();
  return request;
}

v1::ViewerRequest token(const std::string& text) {
  v1::ViewerRequest request;
  request.mutable_authenticate()->set_token(text);
  return request;
}

TEST_F(Viewer, IsGreetedThenShownCellAndState) {
  start();
  RawWebClient client(port);
  ASSERT_NE(client.upgrade().find("101"), std::string::npos);
  const auto first = client.next([](const auto&) { return true; });
  ASSERT_TRUE(first && first->has_welcome());
  EXPECT_EQ(first->welcome().version(), "1.2.3");
  const auto second = client.next([](const auto&) { return true; });
  ASSERT_TRUE(second && second->has_permission());
  EXPECT_TRUE(second->permission().control());
  const auto cell = client.next([](const auto& u) { return u.has_cell() || u.has_snapshot(); });
  ASSERT_TRUE(cell && cell->has_cell()) << "the cell comes before its states";
  EXPECT_EQ(cell->cell().robots_size(), 2);
  world.publish([](api::Snapshot& s) { s.robots[1].joints[2].position_rad = 0.5; });
  const auto moved = client.next([](const auto& u) {
    return u.has_snapshot() && u.snapshot().robots(1).joints(2).position_rad() == 0.5;
  });
  EXPECT_TRUE(moved);
}

TEST_F(Viewer, GetsANewCellBeforeItsStates) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  (void)client.next([](const auto& u) { return u.has_snapshot(); });
  auto cell = std::make_shared<api::CellDescription>(*test::two_robot_cell());
  cell->scene = "other";
  world.publish([&](api::Snapshot& s) {
    s.cell = cell;
    s.epoch = 1;
  });
  const auto next = client.next([](const auto& u) {
    return u.has_cell() || (u.has_snapshot() && u.snapshot().epoch() == 1);
  });
  ASSERT_TRUE(next && next->has_cell());
  EXPECT_EQ(next->cell().scene(), "other");
}

TEST_F(Viewer, CommandsTheSimulation) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  EXPECT_TRUE(client.ask(pause()).ok());
  const auto commands = world.commands();
  ASSERT_EQ(commands.size(), 1u);
  EXPECT_EQ(commands[0].endpoint, 7u);
  EXPECT_TRUE(
      std::holds_alternative<api::Pause>(std::get<api::SimulationCommand>(commands[0].body)));
}

TEST_F(Viewer, SavesAndLoadsStates) {
  options.listeners = [] { return std::vector<web::ListenerCount>{}; };
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  v1::ViewerRequest save, load;
  save.mutable_save_state()->set_name("before the pick");
  load.mutable_load_state()->set_name("before the pick");
  EXPECT_EQ(client.ask(load).message(), "no state is saved as 'before the pick'; none is saved");
  EXPECT_TRUE(client.ask(save).ok());
  world.publish([](api::Snapshot& s) {
    s.saved_states = std::make_shared<std::vector<std::string>>(1, "before the pick");
  });
  const auto listed = client.next(
      [](const auto& u) { return u.has_status() && u.status().saved_states_size() == 1; });
  ASSERT_TRUE(listed);
  EXPECT_EQ(listed->status().saved_states(0), "before the pick");
  EXPECT_TRUE(client.ask(load).ok());
  const auto commands = world.commands();
  ASSERT_EQ(commands.size(), 2u);
  const auto& saved = std::get<api::SimulationCommand>(commands[0].body);
  const auto& loaded = std::get<api::SimulationCommand>(commands[1].body);
  EXPECT_EQ(std::get<api::SaveState>(saved).name, "before the pick");
  EXPECT_EQ(std::get<api::LoadState>(loaded).name, "before the pick");
}

TEST_F(Viewer, CannotResumeWhatHasStoppedOnAFault) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  world.publish([](api::Snapshot& s) {
    s.paused = true;
    s.world_fault = "step 7, body gear: too fast";
  });
  v1::ViewerRequest resume;
  (void)resume.mutable_resume();
  EXPECT_EQ(client.ask(resume).message(),
            "the simulation has stopped until the cell is reset: step 7, body gear: too fast");
  EXPECT_TRUE(world.commands().empty());
}

TEST_F(Viewer, BadRequestsNameTheFieldAndChangeNothing) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  v1::ViewerRequest request;
  request.mutable_set_speed()->set_factor(-1);
  EXPECT_EQ(client.ask(request).field(), "factor");
  request.mutable_conveyor()->set_speed_m_s(9);
  EXPECT_EQ(client.ask(request).field(), "speed_m_s");
  request.mutable_robot()->set_robot(5);
  EXPECT_EQ(client.ask(request).field(), "robot");
  request.mutable_robot()->set_robot(0);
  EXPECT_EQ(client.ask(request).field(), "action");
  request.mutable_robot()->mutable_move_joints()->add_positions_rad(0);
  EXPECT_EQ(client.ask(request).field(), "positions_rad");
  request.mutable_robot()->mutable_move_tool()->mutable_tool_in_reference();
  EXPECT_EQ(client.ask(request).field(), "orientation");
  request.mutable_step()->set_steps(1);
  EXPECT_EQ(client.ask(request).field(), "step");
  request.clear_body();
  EXPECT_FALSE(client.ask(request).ok());
  EXPECT_TRUE(world.commands().empty());
}

TEST_F(Viewer, MayOnlyLookWhenControlIsOff) {
  options.control = false;
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  const auto permission = client.next([](const auto& u) { return u.has_permission(); });
  ASSERT_TRUE(permission);
  EXPECT_FALSE(permission->permission().control());
  EXPECT_FALSE(permission->permission().token_helps());
  EXPECT_NE(permission->permission().reason().find("read-only"), std::string::npos);
  const auto outcome = client.ask(pause());
  EXPECT_FALSE(outcome.ok());
  EXPECT_EQ(outcome.message(), permission->permission().reason());
  EXPECT_TRUE(world.commands().empty());
}

TEST_F(Viewer, NeedsTheTokenWhenOneIsSet) {
  options.token = "right-token";
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  EXPECT_FALSE(client.ask(pause()).ok());
  EXPECT_FALSE(client.ask(token("wrong-token")).ok());
  EXPECT_FALSE(client.ask(pause()).ok());
  EXPECT_TRUE(client.ask(token("right-token")).ok());
  EXPECT_TRUE(client.ask(pause()).ok());
  EXPECT_EQ(world.commands().size(), 1u);
  RawWebClient other(port);
  (void)other.upgrade();
  EXPECT_FALSE(other.ask(pause()).ok()) << "the token counts for its own viewer only";
}

TEST_F(Viewer, TokensCannotBeTriedFast) {
  options.token = "right-token";
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  std::string last;
  for (int i = 0; i < 4; ++i) last = client.ask(token("guess-" + std::to_string(i))).message();
  EXPECT_NE(last.find("too many attempts"), std::string::npos);
}

TEST_F(Viewer, IsClosedForNonsenseAndFloods) {
  start();
  RawWebClient nonsense(port);
  (void)nonsense.upgrade();
  nonsense.send_frame(2, "\xff\xff\xff\xff");
  EXPECT_TRUE(nonsense.closed());
  RawWebClient large(port);
  (void)large.upgrade();
  large.send_frame(2, std::string(60'000, 'x'));
  EXPECT_TRUE(large.closed());
  RawWebClient flood(port);
  (void)flood.upgrade();
  for (int i = 0; i < 1000; ++i) flood.send(pause());
  EXPECT_TRUE(flood.closed());
}

TEST_F(Viewer, OneThatTakesNothingDelaysNoOther) {
  start();
  RawWebClient stuck(port);
  (void)stuck.upgrade();
  RawWebClient other(port);
  (void)other.upgrade();
  for (int i = 1; i <= 50; ++i) {
    world.publish([&](api::Snapshot& s) { s.conveyor.travel_m = i; });
    const auto seen = other.next(
        [&](const auto& u) { return u.has_snapshot() && u.snapshot().conveyor().travel_m() == i; });
    ASSERT_TRUE(seen) << i;
  }
}

TEST_F(Viewer, WatchesTrafficAndRegisters) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  EXPECT_FALSE(crcl_tap.watched());
  v1::ViewerRequest request;
  request.mutable_watch()->set_crcl(true);
  request.mutable_watch()->set_registers(true);
  EXPECT_TRUE(client.ask(request).ok());
  EXPECT_TRUE(crcl_tap.watched());
  crcl_tap.note({.source = "crcl.fanuc", .from_client = true, .type = "MoveToType", .id = 3});
  const auto events = client.next([](const auto& u) { return u.has_wire_events(); });
  ASSERT_TRUE(events);
  EXPECT_EQ(events->wire_events().events(0).type(), "MoveToType");
  world.publish([](api::Snapshot& s) {
    s.conveyor.run = true;
    s.conveyor.speed_setting_m_s = 0.15;
  });
  const auto registers = client.next(
      [](const auto& u) { return u.has_registers() && u.registers().values(2) == 15'000; });
  EXPECT_TRUE(registers);
  request.mutable_watch()->Clear();
  EXPECT_TRUE(client.ask(request).ok());
  EXPECT_FALSE(crcl_tap.watched());
}

TEST_F(Viewer, StoppingSaysGoodbye) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  (void)client.next([](const auto& u) { return u.has_snapshot(); });
  server->stop();
  EXPECT_TRUE(client.closed());
}

}  // namespace
}  // namespace aprsim
