// Programs that a client sends whole.

#include <chrono>

#include "tests/support/eventually.hpp"
#include "tests/unit/protocols/crcl/server_fixture.hpp"

namespace aprsim::crcl_server {
namespace {

class Programs : public ServerTest {
 protected:
  static std::string middle(const std::string& type, int id, const std::string& fields) {
    return "<MiddleCommand xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:type=\"" +
           type + "\"><CommandID>" + std::to_string(id) + "</CommandID>" + fields +
           "</MiddleCommand>";
  }
  static std::string program(const std::string& middles) {
    return "<?xml version='1.0'?><CRCLProgram><Name>demo</Name><InitCanon><CommandID>1</CommandID>"
           "</InitCanon>" +
           middles + "<EndCanon><CommandID>99</CommandID></EndCanon></CRCLProgram>";
  }
  static std::string dwell(int id) { return middle("DwellType", id, "<DwellTime>1</DwellTime>"); }
  static std::string escaped(std::string text) {
    for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos; at += 4) {
      text.replace(at, 1, "&lt;");
    }
    return text;
  }
  /// The robot is done with its `count`-th command.
  void finish(api::Ticket count) { world_.report(0, ticket(count), ActionState::kDone); }
};

TEST_F(Programs, RunInOrderEachCommandWhenTheLastIsDone) {
  TestClient client(port_);
  client.send(program(middle("SetLengthUnitsType", 2, "<UnitName>inch</UnitName>") +
                      middle("MoveToType", 3, move()) +
                      middle("MessageType", 4, "<Message>half</Message>") + dwell(5)));
  EXPECT_NO_THROW(action<api::InitRobot>(ticket(1)));
  crcl::CommandStatus status = client.status().command;
  EXPECT_EQ(status.command_id, 1);
  EXPECT_EQ(status.state, CommandState::kWorking);
  EXPECT_EQ(status.program_file, "demo");
  EXPECT_EQ(status.program_index, 0);
  EXPECT_EQ(status.program_length, 6);
  finish(1);
  EXPECT_NEAR(action<api::MoveTo>(ticket(2)).X_RT.p.x(), 0.0254, 1e-12);
  status = client.status().command;
  EXPECT_EQ(status.command_id, 3);
  EXPECT_EQ(status.name, "MoveToType");
  EXPECT_EQ(status.program_index, 2);
  EXPECT_EQ(client.status().settings->length_unit, crcl::LengthUnit::kInch);
  finish(2);
  EXPECT_NO_THROW(action<api::Dwell>(ticket(3)));
  finish(3);
  EXPECT_NO_THROW(action<api::EndProgram>(ticket(4)));
  EXPECT_EQ(client.status().command.state, CommandState::kWorking);
  finish(4);
  status = client.status().command;
  EXPECT_EQ(status.command_id, 99);
  EXPECT_EQ(status.program_index, 5);
  EXPECT_EQ(status.state, CommandState::kDone);
}

// Nobody asks for anything, and the client that sent it is gone.
TEST_F(Programs, GoOnWithoutTheirClient) {
  {
    TestClient client(port_);
    client.send(program(dwell(2)));
    finish(1);
    ticket(2);
  }
  finish(2);
  finish(3);
  TestClient witness(port_);
  witness.wait_for([](const crcl::Status& status) {
    return status.command.command_id == 99 && status.command.state == CommandState::kDone;
  });
}

TEST_F(Programs, EndWithTheirClientIfToldSo) {
  start({.end_program_with_client = true});
  TestClient witness(port_);
  {
    TestClient client(port_), other(port_);
    client.send(program(dwell(2) + dwell(3)));
    finish(1);
    ticket(2);
  }
  // The present command continues, and none follows it.
  ASSERT_TRUE(test::eventually([&] { return server_->stats().open == 1; }));
  finish(2);
  witness.wait_for([](const crcl::Status& status) {
    return status.command.command_id == 2 && status.command.state == CommandState::kDone;
  });
  ticket(2);
}

// Commands that need no motion are paced, too.
TEST_F(Programs, ArePaced) {
  TestClient client(port_);
  const auto began = std::chrono::steady_clock::now();
  client.send(
      program(middle("LoopBlockStartType", 2, "<LoopName>a</LoopName>") +
              middle("MessageType", 3, "<Message>again</Message>") +
              middle("LoopBlockEndType", 4, "<LoopName>a</LoopName><MaxCount>1000</MaxCount>")));
  finish(1);
  client.wait_for([](const crcl::Status& status) { return status.command.command_id == 99; });
  EXPECT_GE(std::chrono::steady_clock::now() - began, std::chrono::milliseconds(900));
}

TEST_F(Programs, RepeatTheirLoops) {
  TestClient client(port_);
  client.send(
      program(middle("LoopBlockStartType", 2, "<LoopName>a</LoopName>") + dwell(3) +
              middle("LoopBlockEndType", 4, "<LoopName>a</LoopName><MaxCount>3</MaxCount>")));
  for (api::Ticket i = 1; i <= 5; ++i) finish(i);
  client.wait_for([](const crcl::Status& status) { return status.command.command_id == 99; });
  ticket(5);
}

TEST_F(Programs, WithBrokenLoopsDoNotStart) {
  TestClient client(port_);
  client.send(program(middle("LoopBlockStartType", 2, "<LoopName>a</LoopName>") + dwell(3)));
  const crcl::CommandStatus status = client.status().command;
  EXPECT_EQ(status.state, CommandState::kError);
  EXPECT_NE(status.description->find("this loop has no end"), std::string::npos);
  EXPECT_TRUE(world_.commands().empty());
}

TEST_F(Programs, WithABadValueDoNotStart) {
  TestClient client(port_);
  client.send(program(middle("DwellType", 7, "<DwellTime>soon</DwellTime>")));
  expect(client.status(), 7, CommandState::kError,
         "DwellType/DwellTime: 'soon': expected a finite number");
  EXPECT_TRUE(world_.commands().empty());
}

TEST_F(Programs, EndAtTheFirstError) {
  TestClient client(port_);
  client.send(program(middle("MoveToType", 2, move()) + dwell(3)));
  finish(1);
  world_.report(0, ticket(2), ActionState::kError, "out of reach");
  expect(client.status(), 2, CommandState::kError, "out of reach");
  client.command(50, "InitCanonType");
  finish(3);
  expect(client.status(), 50, CommandState::kDone);
  ticket(3);
}

TEST_F(Programs, EndWhenAnyClientNeedsTheRobot) {
  TestClient client(port_), other(port_);
  client.send(program(dwell(2) + dwell(3)));
  finish(1);
  ticket(2);
  other.command(50, "ConfigureStatusReportType", "<ReportPoseStatus>true</ReportPoseStatus>");
  expect(other.status(), 50, CommandState::kDone);  // this one does not
  finish(2);
  ticket(3);
  other.command(51, "StopMotionType", "<StopCondition>Fast</StopCondition>");
  EXPECT_NO_THROW(action<api::StopMotion>(ticket(4)));
  finish(4);
  expect(client.status(), 51, CommandState::kDone);
  ticket(4);
}

TEST_F(Programs, SettingsFromAnotherSocketDoNotConfuseThem) {
  TestClient client(port_), other(port_);
  client.send(program(middle("MoveToType", 2, move()) + dwell(3)));
  finish(1);
  ticket(2);
  world_.publish([](api::Snapshot& next) {
    next.applied = 2;
    next.robots[0].moving = true;
    next.robots[0].action = {2, ActionState::kWorking, ""};
  });
  other.command(50, "SetTransSpeedType",
                "<TransSpeed xsi:type=\"TransSpeedRelativeType\"><Fraction>0.5</Fraction>"
                "</TransSpeed>");
  world_.report(0, ticket(3), ActionState::kDone);  // the setting; the move goes on
  EXPECT_EQ(other.status().command.command_id, 50);
  ticket(3);
  world_.publish([](api::Snapshot& next) { next.robots[0].moving = false; });
  EXPECT_NO_THROW(action<api::Dwell>(ticket(4)));
}

TEST_F(Programs, InARunProgramCommandRunUnderItsId) {
  TestClient client(port_);
  initialize(client);
  client.command(7, "RunProgramType",
                 "<ProgramText>" + escaped(program(dwell(2) + dwell(3))) + "</ProgramText>");
  expect(client.status(), 7, CommandState::kWorking);
  EXPECT_NO_THROW(action<api::Dwell>(ticket(2)));
  finish(2);
  finish(3);
  const crcl::CommandStatus status = client.status().command;
  EXPECT_EQ(status.command_id, 7);
  EXPECT_EQ(status.state, CommandState::kDone);
  EXPECT_EQ(status.program_index, 2);
  ticket(3);  // neither InitCanon nor EndCanon: the session is the client's
}

// The command is over once the program is loaded: nothing has been looked at.
TEST_F(Programs, DoNotRunForARunProgramThatRequiresAGuardTrigger) {
  TestClient client(port_);
  initialize(client);
  client.command(7, "RunProgramType",
                 "<Guard><SensorID>MotoFit</SensorID><SubField>Fz</SubField><LimitType>OVER_MAX"
                 "</LimitType><LimitValue>5</LimitValue><RequireTrigger>true</RequireTrigger>"
                 "</Guard><ProgramText>" +
                     escaped(program(dwell(2))) + "</ProgramText>");
  expect(client.status(), 7, CommandState::kError,
         "RunProgramType ended without the required guard trigger.");
  ticket(1);  // InitCanon alone
}

TEST_F(Programs, InAnotherLanguageAreRefused) {
  TestClient client(port_);
  initialize(client);
  client.command(7, "RunProgramType", "<ProgramText>10 PRINT</ProgramText>");
  expect(client.status(), 7, CommandState::kError,
         "RunProgram runs a CRCLProgram document only; the text begins with \"10 PRINT\".");
}

TEST_F(Programs, NeedTheirSessionLikeAnyCommand) {
  TestClient client(port_);
  client.send("<CRCLProgram>" + dwell(2) + "</CRCLProgram>");
  expect(client.status(), 2, CommandState::kError,
         "Not initialized when cmd=DwellType received. Send InitCanon first.");
  EXPECT_TRUE(world_.commands().empty());
}

TEST_F(Programs, TooLargeOnesEndTheirConnection) {
  CrclServerOptions options;
  options.max_program_bytes = 2000;
  start(options);
  TestClient client(port_);
  client.send(program("<!--" + std::string(2000, 'x') + "-->"));
  client.expect_closed();
}

}  // namespace
}  // namespace aprsim::crcl_server
