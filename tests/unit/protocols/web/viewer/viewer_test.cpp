#include "tests/support/access_with.hpp"
#include "tests/support/eventually.hpp"
#include "tests/unit/protocols/web/web_fixture.hpp"

namespace aprsim {
namespace {

using test::access_with_tokens;
using test::RawWebClient;
using test::rules_with_tokens;
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

v1::ViewerRequest watch(bool crcl, bool modbus, bool polls) {
  v1::ViewerRequest request;
  request.mutable_watch()->set_crcl(crcl);
  request.mutable_watch()->set_modbus(modbus);
  request.mutable_watch()->set_polls(polls);
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
    s.saved_states = std::make_shared<api::SavedStates>(
        api::SavedStates{.states = {{.name = "before the pick"}}});
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
  EXPECT_EQ(client.ask(request).message(), "The robot is not ready: make it ready first.");
  world.publish([](api::Snapshot& s) { s.robots[0].initialized = true; });
  EXPECT_EQ(client.ask(request).field(), "positions_rad");
  request.mutable_robot()->mutable_move_tool()->mutable_tool_in_reference();
  EXPECT_EQ(client.ask(request).field(), "orientation");
  request.mutable_step()->set_steps(1);
  EXPECT_EQ(client.ask(request).field(), "step");
  request.clear_body();
  EXPECT_FALSE(client.ask(request).ok());
  EXPECT_TRUE(world.commands().empty());
}

TEST_F(Viewer, MovesAToolNoFasterThanInManualMode) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  v1::ViewerRequest request;
  auto& move = *request.mutable_robot()->mutable_move_tool();
  move.mutable_tool_in_reference()->mutable_position_m()->set_x(0.3);
  move.mutable_tool_in_reference()->mutable_orientation()->set_w(1);
  move.set_speed(0.5);
  EXPECT_EQ(client.ask(request).message(), "The robot is not ready: make it ready first.");
  world.publish([](api::Snapshot& s) { s.robots[0].initialized = true; });
  ASSERT_TRUE(client.ask(request).ok());
  const auto command = std::get<api::RobotCommand>(world.commands().at(0).body);
  const auto limits = std::get<api::MoveTo>(command.action).limits;
  EXPECT_DOUBLE_EQ(limits.trans_speed->value, 0.125);
  EXPECT_DOUBLE_EQ(limits.rot_speed->value, 0.5);
  move.set_speed(2);
  EXPECT_EQ(client.ask(request).field(), "speed");
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
  options.listener.access = access_with_tokens();
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

TEST_F(Viewer, MayWhatItsRoleMay) {
  options.listener.access = access_with_tokens();
  start();
  v1::ViewerRequest fault, reset;
  (void)fault.mutable_intruder();
  (void)reset.mutable_reset();
  const std::vector<std::pair<std::string, v1::ViewerRequest>> requests{
      {"operate", pause()}, {"inject", fault}, {"admin", reset}};
  for (std::size_t may = 0; may <= requests.size(); ++may) {
    RawWebClient client(port);
    (void)client.upgrade();
    const std::string role = may == 0 ? "view" : requests[may - 1].first;
    client.send(token(role + "-token"));
    const auto permission = client.next(
        [&](const auto& u) { return u.has_permission() && !u.permission().name().empty(); });
    ASSERT_TRUE(permission) << role;
    EXPECT_EQ(permission->permission().role(), role);
    EXPECT_EQ(permission->permission().name(), "token " + role);
    EXPECT_EQ(permission->permission().control(), may > 0);
    EXPECT_EQ(permission->permission().token_helps(), role != "admin");
    for (std::size_t i = 0; i < requests.size(); ++i) {
      const auto outcome = client.ask(requests[i].second);
      EXPECT_EQ(outcome.ok(), i < may) << role << ' ' << outcome.message();
      if (i < may) continue;
      EXPECT_EQ(outcome.field(), "permission");
      EXPECT_NE(outcome.message().find("needs the role " + requests[i].first), std::string::npos);
    }
  }
}

/// A past with one bookmark.
class OneBookmark final : public api::History {
 public:
  [[nodiscard]] std::vector<api::HistorySpan> spans() const override { return {{}}; }
  void ask(api::Moment, Answer answer) override {
    answer(fail(ErrorCode::kNotFound, "moment", "nothing is kept"));
  }
  [[nodiscard]] std::vector<api::Bookmark> bookmarks() const override {
    return {{.id = 1, .text = "a name of a job"}};
  }
  [[nodiscard]] std::uint64_t bookmark_revision() const override { return 1; }
  [[nodiscard]] Result<api::Bookmark> add_bookmark(api::Moment, std::string) override {
    return fail(ErrorCode::kNotFound, "moment", "nothing is kept");
  }
  [[nodiscard]] Result<void> remove_bookmark(std::uint64_t) override { return {}; }
};

TEST_F(Viewer, IsShownNothingWhereLookingNeedsAToken) {
  auto rules = rules_with_tokens();
  rules.local = rules.others = protocols::Role::kNone;
  options.listener.access = std::make_shared<protocols::Access>(rules);
  options.metrics = [] { return std::string("metric 1\n"); };
  OneBookmark history;
  options.history = &history;
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  const auto permission = client.next([](const auto& u) { return u.has_permission(); });
  ASSERT_TRUE(permission);
  EXPECT_EQ(permission->permission().role(), "none");
  EXPECT_TRUE(permission->permission().token_helps());
  EXPECT_FALSE(client.ask(pause()).ok());
  auto request = watch(true, true, true);
  request.set_id(99);
  client.send(request);
  const auto next = client.next([](const auto&) { return true; });
  ASSERT_TRUE(next && next->has_outcome()) << "nothing but answers";
  EXPECT_FALSE(next->outcome().ok());
  ASSERT_TRUE(client.ask(token("view-token")).ok());
  bool snapshot = false, bookmarks = false;
  EXPECT_TRUE(client.next([&](const auto& u) {
    snapshot |= u.has_snapshot();
    bookmarks |= u.has_bookmarks();
    return snapshot && bookmarks;
  }));
  for (const auto& [path, status] : {std::pair("/metrics", "401"), std::pair("/healthz", "200")}) {
    RawWebClient plain(port);
    EXPECT_NE(plain.request("GET " + std::string(path) + " HTTP/1.1").find(status),
              std::string::npos)
        << path;
  }
}

TEST_F(Viewer, TokensCannotBeTriedFast) {
  options.listener.access = access_with_tokens();
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  std::string last;
  for (int i = 0; i < 6; ++i) last = client.ask(token("guess-" + std::to_string(i))).message();
  EXPECT_NE(last.find("too many wrong tokens"), std::string::npos);
  EXPECT_TRUE(client.ask(token("view-token")).ok()) << "a right one is not locked out";
}

TEST_F(Viewer, IsClosedForNonsenseAndFloods) {
  start();
  RawWebClient nonsense(port);
  (void)nonsense.upgrade();
  nonsense.send_frame(2, "\xff\xff\xff\xff");
  EXPECT_TRUE(nonsense.closed());
  RawWebClient large(port);
  (void)large.upgrade();
  large.send_frame(2, std::string(300'000, 'x'));
  EXPECT_TRUE(large.closed());
  RawWebClient flood(port);
  (void)flood.upgrade();
  for (int i = 0; i < 1000; ++i) flood.send(pause());
  EXPECT_TRUE(flood.closed());
}

TEST_F(Viewer, IsDroppedThatDoesNotAnswerAClose) {
  start();
  RawWebClient silent(port);
  (void)silent.upgrade();
  silent.send_frame(2, "\xff\xff\xff\xff");
  silent.send_frame(2, "\xff\xff\xff\xff");
  EXPECT_TRUE(test::eventually([this] { return server->stats().open == 0; }));
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

/// The next event of a wire of this type.
std::optional<v1::WireEvent> next_event(RawWebClient& client, const std::string& wire,
                                        const std::string& type) {
  std::optional<v1::WireEvent> found;
  (void)client.next([&](const auto& update) {
    if (!update.has_wire_events() || update.wire_events().wire() != wire) return false;
    for (const auto& event : update.wire_events().events()) {
      if (event.type() == type) found = event;
    }
    return found.has_value();
  });
  return found;
}

TEST_F(Viewer, SeesTheCommandsFromBeforeItCame) {
  start();
  world.publish([](api::Snapshot& s) { s.time = std::chrono::milliseconds(1250); });
  crcl_tap.record({.source = "crcl.fanuc", .from_client = true, .type = "MoveToType", .id = 3});
  crcl_tap.record({.source = "crcl.fanuc", .poll = true, .type = "GetStatusType"});
  RawWebClient client(port);
  (void)client.upgrade();
  EXPECT_TRUE(client.ask(watch(true, false, false)).ok());
  const auto update = client.next([](const auto& u) { return u.has_wire_events(); });
  ASSERT_TRUE(update);
  ASSERT_EQ(update->wire_events().events_size(), 1);
  EXPECT_EQ(update->wire_events().wire(), "crcl");
  const v1::WireEvent& event = update->wire_events().events(0);
  EXPECT_EQ(event.type(), "MoveToType");
  EXPECT_DOUBLE_EQ(event.sim_time_s(), 1.25);
  EXPECT_FALSE(crcl_tap.wants_polls());
  EXPECT_TRUE(client.ask(watch(true, false, true)).ok());
  EXPECT_TRUE(crcl_tap.wants_polls());
  crcl_tap.record(
      {.source = "crcl.fanuc", .from_client = true, .poll = true, .type = "GetStatusType"});
  const auto poll = next_event(client, "crcl", "GetStatusType");
  ASSERT_TRUE(poll);
  EXPECT_TRUE(poll->poll());
  EXPECT_TRUE(client.ask(watch(false, false, true)).ok());
  EXPECT_FALSE(crcl_tap.wants_polls());
}

TEST_F(Viewer, GetsAllOfManyCommandsInOrder) {
  start();
  for (int i = 1; i <= 3000; ++i) {
    crcl_tap.record({.source = i % 2 ? "crcl.fanuc" : "crcl.motoman",
                     .from_client = true,
                     .type = "DwellType",
                     .id = i,
                     .data = std::string(900, 'x')});
  }
  RawWebClient client(port);
  (void)client.upgrade();
  client.send(watch(true, false, false));
  std::int64_t last = 0;
  const auto done = client.next([&](const auto& update) {
    for (const auto& event : update.wire_events().events()) EXPECT_EQ(event.id(), ++last);
    return last == 3000;
  });
  EXPECT_TRUE(done) << last;
}

TEST_F(Viewer, CommandsOfPagesStandAmongTheOthers) {
  start();
  RawWebClient client(port), other(port);
  (void)client.upgrade();
  (void)other.upgrade();
  EXPECT_TRUE(client.ask(pause()).ok());
  EXPECT_TRUE(client.ask(token("never-kept")).ok());
  v1::ViewerRequest request;
  request.mutable_robot()->set_robot(1);
  (void)request.mutable_robot()->mutable_move_tool();
  EXPECT_FALSE(client.ask(request).ok());
  request.mutable_conveyor()->set_run(true);
  EXPECT_TRUE(client.ask(request).ok());
  other.send(watch(true, true, false));
  const auto moved = next_event(other, "crcl", "motoman move_tool");
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->source(), "page");
  EXPECT_EQ(moved->state(), "The robot is not ready: make it ready first.");
  const auto belt = next_event(other, "modbus", "conveyor");
  ASSERT_TRUE(belt);
  EXPECT_NE(belt->data().find("\"run\":true"), std::string::npos) << belt->data();
  std::vector<protocols::WireEventPtr> all;
  (void)crcl_tap.read(1, true, 1 << 20, all);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0]->type, "pause");
  for (const auto& event : all) EXPECT_EQ(event->data.find("never-kept"), std::string::npos);
}

TEST_F(Viewer, WatchesRegisters) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  v1::ViewerRequest request;
  request.mutable_watch()->set_registers(true);
  EXPECT_TRUE(client.ask(request).ok());
  world.publish([](api::Snapshot& s) {
    s.conveyor.run = true;
    s.conveyor.speed_setting_m_s = 0.15;
  });
  const auto registers = client.next(
      [](const auto& u) { return u.has_registers() && u.registers().values(2) == 15'000; });
  EXPECT_TRUE(registers);
}

v1::ViewerRequest write_of(const std::string& area, std::uint32_t address, std::int64_t value) {
  v1::ViewerRequest request;
  auto& inner = *request.mutable_write_register();
  inner.set_area(area);
  inner.set_address(address);
  inner.set_value(value);
  return request;
}

TEST_F(Viewer, WritesRegisters) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  EXPECT_TRUE(client.ask(write_of("holding", 0x8002, 15'000)).ok());
  EXPECT_TRUE(client.ask(write_of("coil", 0x8002, 1)).ok());
  const auto commands = world.commands();
  ASSERT_EQ(commands.size(), 2u);
  EXPECT_EQ(commands[0].endpoint, 7u);
  EXPECT_DOUBLE_EQ(std::get<api::ConveyorCommand>(commands[0].body).speed_m_s.value_or(0), 0.15);
  EXPECT_EQ(std::get<api::ConveyorCommand>(commands[1].body).emergency_stop, true);
  const auto too_fast = client.ask(write_of("holding", 0x8002, 40'000));
  EXPECT_EQ(too_fast.field(), "value");
  EXPECT_EQ(too_fast.message(), "40000 is not in 0..32768, the range of speed (0x8002)");
  EXPECT_EQ(client.ask(write_of("coil", 0x8002, 2)).field(), "value");
  EXPECT_EQ(client.ask(write_of("holding", 0x8002, -1)).field(), "value");
  EXPECT_EQ(client.ask(write_of("input", 0x8000, 1)).field(), "area");
  EXPECT_EQ(client.ask(write_of("holding", 0x8003, 1)).field(), "address");
  EXPECT_EQ(client.ask(write_of("holding", 0x18002, 1)).field(), "address");
  world.refuse(Error{ErrorCode::kUnavailable, "queue", "full"});
  EXPECT_NE(client.ask(write_of("holding", 0x8002, 1)).message().find("try again"),
            std::string::npos);
  EXPECT_EQ(world.commands().size(), 2u);
}

TEST_F(Viewer, WritesNoRegistersWithoutPermission) {
  options.control = false;
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  EXPECT_FALSE(client.ask(write_of("holding", 0x8002, 15'000)).ok());
  EXPECT_TRUE(world.commands().empty());
}

TEST_F(Viewer, StopsTheWholeCellAtOnce) {
  start();
  RawWebClient client(port);
  (void)client.upgrade();
  v1::ViewerRequest stop;
  (void)stop.mutable_stop_cell();
  EXPECT_TRUE(client.ask(stop).ok());
  const auto commands = world.commands();
  ASSERT_EQ(commands.size(), 3u);
  for (int robot = 0; robot < 2; ++robot) {
    const auto& command =
        std::get<api::RobotCommand>(commands[static_cast<std::size_t>(robot)].body);
    EXPECT_EQ(command.robot, robot);
    EXPECT_TRUE(std::holds_alternative<api::StopMotion>(command.action));
  }
  EXPECT_EQ(std::get<api::ConveyorCommand>(commands[2].body).run, false);
}

TEST_F(Viewer, IsToldWhatWentWrongBeforeItCame) {
  start();
  {
    RawWebClient first(port);
    (void)first.upgrade();
    world.publish([](api::Snapshot& s) {
      s.robots[1].protective_stop = true;
      s.robots[1].action.description = "joint 3: collision";
    });
    EXPECT_TRUE(first.next([](const auto& u) { return u.faults().faults_size() == 1; }));
  }
  RawWebClient later(port);
  (void)later.upgrade();
  const auto list = later.next([](const auto& u) { return u.has_faults(); });
  ASSERT_TRUE(list);
  ASSERT_EQ(list->faults().faults_size(), 1);
  const v1::Fault& fault = list->faults().faults(0);
  EXPECT_EQ(fault.source(), "motoman");
  EXPECT_EQ(fault.severity(), v1::FAULT_SEVERITY_STOP);
  EXPECT_EQ(fault.message(), "joint 3: collision");
  EXPECT_TRUE(fault.active());
  EXPECT_GT(fault.last().time_s(), 1.5e9);
  world.publish([](api::Snapshot& s) { s.robots[1].protective_stop = false; });
  EXPECT_TRUE(
      later.next([](const auto& u) { return u.has_faults() && !u.faults().faults(0).active(); }));
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
