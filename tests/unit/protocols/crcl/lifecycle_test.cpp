// The rules by which a command's id and state show in the statuses.

#include "tests/unit/protocols/crcl/server_fixture.hpp"

namespace aprsim::crcl_server {
namespace {

using Lifecycle = ServerTest;

TEST_F(Lifecycle, BeforeTheFirstCommandTheRobotIsReady) {
  TestClient client(port_);
  const crcl::Status status = client.status();
  expect(status, -1, CommandState::kReady);
  EXPECT_EQ(status.command.name, std::nullopt);
}

TEST_F(Lifecycle, OnlyGetStatusIsAnswered) {
  TestClient client(port_);
  client.command(4, "InitCanonType");
  client.command(5, "MessageType", "<Message>hi</Message>");
  client.command(6, "FlyType");  // unknown: the connection ends
  client.expect_closed();
}

TEST_F(Lifecycle, EachGetStatusHasOneAnswerInOrder) {
  TestClient client(port_);
  std::string packet;
  for (int i = 0; i < 50; ++i) packet += crcl::with_id("GetStatusType", "");
  client.send(packet);
  client.finish_sending();
  const std::int64_t first = client.read_status().command.status_id;
  for (int i = 1; i < 50; ++i) EXPECT_EQ(client.read_status().command.status_id, first + i);
  client.expect_closed();
}

TEST_F(Lifecycle, ACommandShowsAtOnceAndIsNotDoneTooEarly) {
  TestClient client(port_);
  initialize(client);
  client.send(crcl::with_id("MoveToType", move()) + crcl::with_id("GetStatusType", ""));
  const crcl::Status status = client.read_status();
  expect(status, 7, CommandState::kWorking);
  EXPECT_EQ(status.command.name, "MoveToType");
  world_.report(0, ticket(2), ActionState::kWorking);
  expect(client.status(), 7, CommandState::kWorking);
  world_.report(0, 2, ActionState::kDone);
  expect(client.status(), 7, CommandState::kDone);
}

TEST_F(Lifecycle, InitCanonWorksUntilTheRobotIsReady) {
  TestClient client(port_);
  client.command(4, "InitCanonType");
  expect(client.status(), 4, CommandState::kWorking);
  EXPECT_NO_THROW(action<api::InitRobot>(ticket(1)));
  world_.report(0, 1, ActionState::kWorking);
  expect(client.status(), 4, CommandState::kWorking);
  world_.report(0, 1, ActionState::kDone);
  expect(client.status(), 4, CommandState::kDone);
}

TEST_F(Lifecycle, NothingButInitCanonStartsASession) {
  TestClient client(port_);
  for (const char* type : {"MoveToType", "SetLengthUnitsType", "MessageType",
                           "ConfigureStatusReportType", "RunProgramType", "DwellType"}) {
    SCOPED_TRACE(type);
    TestClient fresh(port_);
    fresh.command(
        4, type, move() + "<UnitName>meter</UnitName><Message>m</Message><DwellTime>1</DwellTime>");
    const crcl::Status status = fresh.status();
    EXPECT_EQ(status.command.command_id, 4);
    EXPECT_EQ(status.command.state, CommandState::kError);
    EXPECT_EQ(status.settings->length_unit, crcl::LengthUnit::kMillimeter);
  }
  EXPECT_EQ(client.status().command.description,
            "In error until InitCanon: Not initialized when cmd=MoveToType received. Send "
            "InitCanon first.");
  EXPECT_TRUE(world_.commands().empty());
  initialize(client);
}

TEST_F(Lifecycle, StopMotionAndEndCanonAreFineBeforeInitCanon) {
  TestClient client(port_);
  client.command(1, "StopMotionType", "<StopCondition>Fast</StopCondition>");
  expect(client.status(), 1, CommandState::kDone);
  client.command(2, "EndCanonType");
  expect(client.status(), 2, CommandState::kDone);
}

TEST_F(Lifecycle, StopMotionBeforeInitCanonStopsAStreamOfMotions) {
  world_.publish([](api::Snapshot& next) { next.robots[0].motion.stream = 5; });
  TestClient client(port_);
  client.command(1, "StopMotionType", "<StopCondition>Fast</StopCondition>");
  EXPECT_EQ(action<api::StopMotion>(ticket(1)).kind, api::StopKind::kFast);
  world_.report(0, ticket(1), ActionState::kDone);
  expect(client.status(), 1, CommandState::kDone);
}

TEST_F(Lifecycle, IdsThatRepeatOrGoDownAreExecuted) {
  TestClient client(port_);
  initialize(client);
  api::Ticket sent = 1;
  for (const std::int64_t id : {9, 9, 3, 1, 0, -5, 4}) {
    client.command(id, "MoveToType", move());
    expect(client.status(), id, CommandState::kWorking);
    world_.report(0, ticket(++sent), ActionState::kDone);
    expect(client.status(), id, CommandState::kDone);
  }
}

TEST_F(Lifecycle, GetStatusChangesNeitherIdNorState) {
  TestClient client(port_);
  initialize(client);
  for (const char* id : {"<CommandID>77</CommandID>", "", "<CommandID>x</CommandID>"}) {
    client.send(crcl::instance("GetStatusType", id));
    expect(client.read_status(), 4, CommandState::kDone);
  }
}

TEST_F(Lifecycle, LocalSettingsAreDoneAtOnceEvenWhileTheArmMoves) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move());
  world_.report(0, ticket(2), ActionState::kWorking);
  client.command(6, "SetLengthUnitsType", "<UnitName>meter</UnitName>");
  expect(client.status(), 6, CommandState::kDone);
  ticket(2);
}

// At once, since later commands find it applied anyway: a client that steps the cell by itself must
// not see by chance whether the simulation was quick.
TEST_F(Lifecycle, ALimitOfLaterMotionIsDoneAtOnce) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move());
  world_.report(0, ticket(2), ActionState::kWorking);
  const std::string speed =
      "<TransSpeed xsi:type=\"TransSpeedAbsoluteType\"><Setting>200</Setting></TransSpeed>";
  client.command(6, "SetTransSpeedType", speed);
  const crcl::Status status = client.status();
  expect(status, 6, CommandState::kDone);
  EXPECT_NEAR(status.settings.value().trans_speed.value().value, 200, 1e-9);
  ticket(3);
  // Applied; the robot's action is still the move.
  world_.publish([](api::Snapshot& next) {
    next.applied = 3;
    next.robots[0].trans_speed = {false, 0.2};
  });
  expect(client.status(), 6, CommandState::kDone);
}

TEST_F(Lifecycle, TheLatestMoveWins) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move());
  client.command(6, "MoveToType", move());
  ticket(3);
  const std::string told = "MoveToType 5 ended before its target.";
  world_.report(0, 2, ActionState::kDone);
  expect(client.status(), 6, CommandState::kWorking, told);
  world_.report(0, 3, ActionState::kDone);
  expect(client.status(), 6, CommandState::kDone, told);
}

TEST_F(Lifecycle, StopComesFromAnotherSocketWithALowerId) {
  TestClient commands(port_);
  TestClient emergency(port_);
  initialize(commands);
  commands.command(9, "MoveToType", move());
  world_.report(0, ticket(2), ActionState::kWorking);
  emergency.command(8, "StopMotionType", "<StopCondition>Immediate</StopCondition>");
  EXPECT_EQ(action<api::StopMotion>(ticket(3)).kind, api::StopKind::kImmediate);
  const std::string told = "MoveToType 9 ended before its target.";
  world_.report(0, 3, ActionState::kWorking);
  expect(commands.status(), 8, CommandState::kWorking, told);
  world_.report(0, 3, ActionState::kDone);
  expect(commands.status(), 8, CommandState::kDone, told);
}

TEST_F(Lifecycle, AMessageIsShown) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MessageType", "<Message>pick &lt;gear&gt;</Message>");
  expect(client.status(), 5, CommandState::kDone, "pick <gear>");
  client.command(6, "SetForceUnitsType", "<UnitName>pound</UnitName>");
  expect(client.status(), 6, CommandState::kDone);
}

// The pendant client sends InitCanon only once, and jogs after a program.
TEST_F(Lifecycle, EndCanonLeavesTheRobotInitialized) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "EndCanonType");
  EXPECT_NO_THROW(action<api::EndProgram>(ticket(2)));
  world_.report(0, 2, ActionState::kDone);
  expect(client.status(), 5, CommandState::kDone);
  client.command(6, "MessageType", "<Message>bye</Message>");
  expect(client.status(), 6, CommandState::kDone, "bye");
  client.command(7, "MoveToType", move());
  world_.report(0, ticket(3), ActionState::kDone);
  expect(client.status(), 7, CommandState::kDone);
  client.command(8, "SetEndEffectorType", "<Setting>0</Setting>");
  EXPECT_EQ(action<api::SetGripper>(ticket(4)).setting, 0);
}

// As NIST's servers name it: the type, with the command's own name behind.
TEST_F(Lifecycle, AStatusNamesTheCommand) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "DwellType", "<DwellTime>1</DwellTime>");
  EXPECT_EQ(client.status().command.name, "DwellType");
  const auto named = [&](const std::string& name) {
    client.send(crcl::instance("DwellType", "<Name>" + name +
                                                "</Name><CommandID>6</CommandID>"
                                                "<DwellTime>1</DwellTime>"));
    return client.status().command.name.value_or("none");
  };
  EXPECT_EQ(named("settle"), "DwellTypesettle");
  EXPECT_EQ(named("DwellType7"), "DwellType");
  EXPECT_EQ(named(std::string(200, 'x')).size(), 120U);
}

TEST_F(Lifecycle, TheDescriptionIsEmptyWhereThereIsNothingToSay) {
  TestClient client(port_);
  initialize(client);
  client.command(0, "GetStatusType");
  const std::string document = client.read_document();
  EXPECT_NE(document.find("<StateDescription></StateDescription>"), std::string::npos) << document;
}

TEST_F(Lifecycle, TheProgramPositionIsEchoed) {
  TestClient client(port_);
  initialize(client);
  client.send(crcl::instance("MessageType", "<CommandID>5</CommandID><Message>m</Message>",
                             "<ProgramFile>p.xml</ProgramFile><ProgramIndex>3</ProgramIndex>"
                             "<ProgramLength>22</ProgramLength>"));
  const crcl::CommandStatus status = client.status().command;
  EXPECT_EQ(status.program_file, "p.xml");
  EXPECT_EQ(status.program_index, 3);
  EXPECT_EQ(status.program_length, 22);
  client.command(6, "MessageType", "<Message>m</Message>");
  EXPECT_EQ(client.status().command.program_file, std::nullopt);
}

TEST_F(Lifecycle, AResetOfTheCellEndsTheSession) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move());
  ticket(2);
  const auto reset = [](api::Snapshot& next) {
    ++next.epoch;
    next.robots[0] = {};
  };
  world_.publish(reset);
  expect(client.status(), 5, CommandState::kError, "The cell was reset before MoveToType ended.");
  client.command(6, "InitCanonType");
  world_.report(0, ticket(3), ActionState::kDone);
  expect(client.status(), 6, CommandState::kDone);
  world_.publish(reset);
  expect(client.status(), 6, CommandState::kReady, "The cell was reset.");
  client.command(7, "MoveToType", move());
  EXPECT_EQ(client.status().command.state, CommandState::kError);
}

TEST_F(Lifecycle, AStoppedSimulationIsAnErrorUntilTheCellIsReset) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move());
  world_.report(0, ticket(2), ActionState::kWorking);
  expect(client.status(), 5, CommandState::kWorking);
  world_.publish([](api::Snapshot& next) { next.world_fault = "step 7, body gear: too fast"; });
  const std::string why =
      "The simulation has stopped until the cell is reset: step 7, body gear: too fast";
  expect(client.status(), 5, CommandState::kError, why);
  client.command(6, "InitCanonType");
  expect(client.status(), 6, CommandState::kError, why);
  world_.publish([](api::Snapshot& next) {
    ++next.epoch;
    next.world_fault.clear();
    next.robots[0] = {};
  });
  client.command(7, "InitCanonType");
  world_.report(0, ticket(4), ActionState::kDone);
  expect(client.status(), 7, CommandState::kDone);
}

TEST_F(Lifecycle, ASavedStateBringsItsSessionAndCommandBack) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move());
  world_.report(0, ticket(2), ActionState::kWorking);
  expect(client.status(), 5, CommandState::kWorking);
  client.command(6, "MoveToType", move());
  world_.report(0, ticket(3), ActionState::kWorking);
  const std::int64_t asked = client.status().command.status_id;
  world_.publish([](api::Snapshot& next) {
    ++next.epoch;
    next.robots[0].initialized = true;
    next.robots[0].action = {2, ActionState::kWorking, ""};
  });
  const crcl::Status loaded = client.status();
  expect(loaded, 5, CommandState::kWorking, "The cell went on from a saved state.");
  EXPECT_GT(loaded.command.status_id, asked);
  world_.report(0, 2, ActionState::kDone);
  expect(client.status(), 5, CommandState::kDone, "The cell went on from a saved state.");
  client.command(7, "MoveToType", move());
  world_.report(0, ticket(4), ActionState::kDone);
  expect(client.status(), 7, CommandState::kDone);
}

TEST_F(Lifecycle, ASavedStateOfAStoppedRobotIsInErrorUntilInitCanon) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move());
  world_.report(0, ticket(2), ActionState::kError, "Protective stop: hit the table");
  client.command(6, "InitCanonType");
  world_.report(0, ticket(3), ActionState::kDone);
  expect(client.status(), 6, CommandState::kDone);
  world_.publish([](api::Snapshot& next) {
    ++next.epoch;
    next.robots[0].action = {2, ActionState::kError, "Protective stop: hit the table"};
  });
  expect(client.status(), 5, CommandState::kError, "Protective stop: hit the table");
  client.command(7, "InitCanonType");
  world_.report(0, ticket(4), ActionState::kDone);
  expect(client.status(), 7, CommandState::kDone);
}

TEST_F(Lifecycle, ASavedStateOfAnEndedProgramGoesOn) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "EndCanonType");
  const api::ActionStatus ended{ticket(2), ActionState::kDone, "", api::ActionKind::kEnd};
  world_.publish([&](api::Snapshot& next) {
    next.robots[0].action = ended;
    next.applied = 2;
  });
  expect(client.status(), 5, CommandState::kDone);
  client.command(6, "InitCanonType");
  world_.report(0, ticket(3), ActionState::kDone);
  expect(client.status(), 6, CommandState::kDone);
  world_.publish([&](api::Snapshot& next) {
    ++next.epoch;
    next.robots[0].action = ended;
    next.robots[0].initialized = true;
  });
  expect(client.status(), 5, CommandState::kDone, "The cell went on from a saved state.");
  client.command(7, "MoveToType", move());
  expect(client.status(), 7, CommandState::kWorking);
}

TEST_F(Lifecycle, ACompletedCommandStaysDone) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move());
  world_.report(0, ticket(2), ActionState::kDone);
  expect(client.status(), 5, CommandState::kDone);
  world_.report(0, 9, ActionState::kWorking);
  expect(client.status(), 5, CommandState::kDone);
}

TEST_F(Lifecycle, MotionGoesOnWhenTheClientLeaves) {
  TestClient witness(port_);
  {
    TestClient client(port_);
    initialize(client);
    client.command(5, "MoveToType", move());
    ticket(2);
  }
  witness.wait_for([&](const crcl::Status&) { return server_->stats().open == 1; });
  expect(witness.status(), 5, CommandState::kWorking);
  ticket(2);
}

// A controller that was killed, or a cable that was cut: the robot stops, as by NIST's servers.
TEST_F(Lifecycle, AConnectionThatIsLostStopsTheRobot) {
  TestClient witness(port_);
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move());
  ticket(2);
  expect(client.status(), 5, CommandState::kWorking);
  client.reset();
  const crcl::Status status = witness.wait_for(
      [](const crcl::Status& now) { return now.command.state == CommandState::kError; });
  EXPECT_EQ(status.command.command_id, 5);
  const std::string why = status.command.description.value_or("");
  EXPECT_EQ(why.rfind("The connection of 127.0.0.1:", 0), 0U) << why;
  EXPECT_NE(why.find(" was lost: Connection reset by peer"), std::string::npos) << why;
  EXPECT_EQ(action<api::StopMotion>(ticket(3)).kind, api::StopKind::kFast);
  witness.command(6, "InitCanonType");
  world_.report(0, ticket(4), ActionState::kDone);
  expect(witness.status(), 6, CommandState::kDone, "MoveToType 5 ended before its target.");
}

TEST_F(Lifecycle, AReaderThatIsLostStopsNothing) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move());
  ticket(2);
  TestClient reader(port_);
  reader.status();
  reader.reset();
  client.wait_for([&](const crcl::Status&) { return server_->stats().open == 1; });
  expect(client.status(), 5, CommandState::kWorking);
  ticket(2);
}

// Command, emergency stop and polling socket, the latter with a report configuration of its own.
TEST_F(Lifecycle, ThreeSocketsAsThePendantOpensThem) {
  TestClient commands(port_);
  TestClient emergency(port_);
  TestClient poll(port_);
  initialize(commands);
  poll.command(5, "ConfigureStatusReportType",
               "<ReportJointStatuses>true</ReportJointStatuses><ReportPoseStatus>true"
               "</ReportPoseStatus><ReportGripperStatus>true</ReportGripperStatus>"
               "<ReportSettingsStatus>true</ReportSettingsStatus><ReportSensorsStatus>false"
               "</ReportSensorsStatus><ReportGuardsStatus>false</ReportGuardsStatus>");
  expect(poll.status(), 5, CommandState::kDone);
  commands.command(6, "SetLengthUnitsType", "<UnitName>millimeter</UnitName>");
  expect(commands.status(), 6, CommandState::kDone);
  commands.command(7, "MoveToType", move());
  ticket(2);
  for (int i = 0; i < 20; ++i) expect(poll.status(), 7, CommandState::kWorking);
  EXPECT_TRUE(poll.status().gripper.has_value());
  EXPECT_FALSE(commands.status().gripper.has_value());
  world_.report(0, 2, ActionState::kDone);
  expect(poll.status(), 7, CommandState::kDone);
  emergency.command(6, "StopMotionType", "<StopCondition>Fast</StopCondition>");
  world_.report(0, ticket(3), ActionState::kDone);
  expect(poll.wait_for([](const crcl::Status& s) { return s.command.command_id == 6; }), 6,
         CommandState::kDone);
}

}  // namespace
}  // namespace aprsim::crcl_server
