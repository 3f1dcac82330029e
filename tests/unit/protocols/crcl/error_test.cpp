// Causes of a robot's error state, its latching and its report.

#include "tests/unit/protocols/crcl/server_fixture.hpp"

namespace aprsim::crcl_server {
namespace {

using Errors = ServerTest;

TEST_F(Errors, AnErrorIsHeldUntilInitCanon) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move());
  world_.report(0, ticket(2), ActionState::kError, "Joint 3 at -171.0 less than limit -170.0");
  expect(client.status(), 5, CommandState::kError, "Joint 3 at -171.0 less than limit -170.0");
  client.command(6, "MoveToType", move());
  expect(client.status(), 6, CommandState::kError,
         "In error until InitCanon: Joint 3 at -171.0 less than limit -170.0");
  client.command(7, "SetLengthUnitsType", "<UnitName>meter</UnitName>");
  EXPECT_EQ(client.status().command.state, CommandState::kError);
  ticket(2);
  // The id of the failed command again, as a client that starts anew would send it.
  client.command(5, "InitCanonType");
  ticket(3);
  expect(client.status(), 5, CommandState::kWorking);  // the snapshot still shows the old error
  world_.report(0, 3, ActionState::kDone);
  expect(client.status(), 5, CommandState::kDone);
  client.command(5, "MoveToType", move());
  ticket(4);
}

TEST_F(Errors, AnErrorIsNoticedThoughNobodyAsked) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move());
  world_.report(0, ticket(2), ActionState::kError, "out of reach");
  client.command(6, "MoveToType", move());
  expect(client.status(), 6, CommandState::kError, "In error until InitCanon: out of reach");
  ticket(2);
}

TEST_F(Errors, AnErrorOfTheRobotAtRestShows) {
  TestClient client(port_);
  initialize(client);
  world_.publish([](api::Snapshot& next) {
    next.robots[0].protective_stop = true;
    next.robots[0].action.state = ActionState::kError;
    next.robots[0].action.description = "link 4 hit the table";
  });
  expect(client.status(), 4, CommandState::kError, "link 4 hit the table");
}

TEST_F(Errors, AnErrorAlwaysHasADescription) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "DwellType", "<DwellTime>1</DwellTime>");
  world_.report(0, ticket(2), ActionState::kError);
  EXPECT_NE(client.status().command.description.value_or(""), "");
}

TEST_F(Errors, StopStillStopsInError) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "RunProgramType", "<ProgramText>x</ProgramText>");
  client.command(6, "StopMotionType", "<StopCondition>Normal</StopCondition>");
  EXPECT_EQ(action<api::StopMotion>(ticket(2)).kind, api::StopKind::kNormal);
  world_.report(0, 2, ActionState::kDone);
  EXPECT_EQ(client.status().command.state, CommandState::kError);
}

TEST_F(Errors, ALoopAloneIsRefused) {
  TestClient client(port_);
  initialize(client);
  client.command(11, "LoopBlockStartType", "<LoopName>l</LoopName>");
  expect(client.status(), 11, CommandState::kError,
         "LoopBlockStartType is valid only within a program: send the whole CRCLProgram, or expand "
         "the loop.");
}

TEST_F(Errors, BadValuesAreErrorsOfTheirCommand) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move("<X>1</X><Y>two</Y><Z>3</Z>"));
  expect(client.status(), 5, CommandState::kError,
         "MoveToType/EndPosition/Point/Y: 'two': expected a finite number");
  ticket(1);
}

TEST_F(Errors, JointNumbersBeginAtOne) {
  const auto actuate = [](int joint) {
    return "<ActuateJoint><JointNumber>" + std::to_string(joint) +
           "</JointNumber><JointPosition>1</JointPosition></ActuateJoint>";
  };
  for (const int joint : {0, 7, -1}) {
    TestClient client(port_);
    client.command(4, "InitCanonType");
    client.command(5, "ActuateJointsType", actuate(joint));
    expect(client.status(), 5, CommandState::kError,
           "Bad joint index:" + std::to_string(joint) + "; this robot has joints 1 to 6");
  }
}

TEST_F(Errors, TolerancesOfJointsThatTheRobotLacksAreNone) {
  const auto tolerances = [](int first, int last) {
    std::string text = "<JointTolerances>";
    for (int joint = first; joint <= last; ++joint) {
      text += "<Setting><JointNumber>" + std::to_string(joint) +
              "</JointNumber><JointPositionTolerance>2</JointPositionTolerance></Setting>";
    }
    return text + "</JointTolerances>";
  };
  TestClient client(port_);
  initialize(client);
  client.command(5, "SetDefaultJointPositonsTolerancesType", tolerances(1, 8));
  const auto status = client.status();
  expect(status, 5, CommandState::kDone);
  ASSERT_TRUE(status.settings);
  EXPECT_EQ(status.settings->joint_tolerances.size(), 6U);
  client.command(6, "SetDefaultJointPositonsTolerancesType", tolerances(0, 6));
  expect(client.status(), 6, CommandState::kError, "Bad joint index:0; joints are counted from 1");
}

TEST_F(Errors, AFullQueueIsAnError) {
  TestClient client(port_);
  initialize(client);
  world_.refuse(Error{ErrorCode::kUnavailable, "queue", "256 commands wait already"});
  client.command(5, "MoveToType", move());
  expect(client.status(), 5, CommandState::kError,
         "MoveToType not accepted: 256 commands wait already");
  client.command(6, "InitCanonType");
  EXPECT_EQ(client.status().command.state, CommandState::kError);
  world_.refuse(std::nullopt);
  client.command(7, "InitCanonType");
  world_.report(0, ticket(2), ActionState::kDone);
  expect(client.status(), 7, CommandState::kDone);
}

TEST_F(Errors, ABrokenDocumentEndsItsConnectionAndStopsTheRobot) {
  TestClient culprit(port_);
  TestClient witness(port_);
  initialize(witness);
  witness.command(5, "MoveToType", move());
  world_.report(0, ticket(2), ActionState::kWorking);
  culprit.send("<CRCLCommandInstance><oops></CRCLCommandInstance>");
  culprit.expect_closed();
  EXPECT_EQ(action<api::StopMotion>(ticket(3)).kind, api::StopKind::kFast);
  const crcl::CommandStatus status = witness.status().command;
  EXPECT_EQ(status.command_id, 5);
  EXPECT_EQ(status.state, CommandState::kError);
  EXPECT_EQ(status.description->substr(0, 28), "Bad document from 127.0.0.1:");
  world_.report(0, 3, ActionState::kDone);
  TestClient again(port_);
  EXPECT_EQ(again.status().command.state, CommandState::kError);
  again.command(6, "InitCanonType");
  world_.report(0, ticket(4), ActionState::kDone);
  expect(witness.status(), 6, CommandState::kDone);
  EXPECT_EQ(server_->stats().dropped, 1U);
}

TEST_F(Errors, StatusesBeforeABrokenDocumentAreStillAnswered) {
  TestClient client(port_);
  client.send(crcl::with_id("GetStatusType", "") + crcl::with_id("GetStatusType", "") +
              "</CRCLCommandInstance>" + crcl::with_id("GetStatusType", ""));
  client.read_status();
  client.read_status();
  client.expect_closed();
}

TEST_F(Errors, AForeignCommandThatReplacesOursIsAnError) {
  TestClient client(port_);
  initialize(client);
  client.command(5, "MoveToType", move());
  ticket(2);
  world_.report(0, 9, ActionState::kDone);
  expect(client.status(), 5, CommandState::kError,
         "MoveToType was replaced by a command from another interface.");
}

}  // namespace
}  // namespace aprsim::crcl_server
