#include <algorithm>

#include <nlohmann/json.hpp>

#include "crcl/command_codec.hpp"
#include "tests/unit/clients/aprsim/cli_fixture.hpp"
#include "tests/unit/clients/aprsim/scripted_robot.hpp"

namespace aprsim::test {
namespace {

crcl::CommandStatus done(const crcl::Command& command) {
  return {.command_id = command.id, .state = crcl::CommandState::kDone};
}

std::string document(const crcl::CommandBody& body, std::int64_t id) {
  crcl::CommandInstance instance;
  instance.command.id = id;
  instance.command.body = body;
  return crcl::encode_command(instance);
}

/// A program document around the given middle commands.
std::string program(const std::string& middle) {
  return "<?xml version=\"1.0\"?>\n<CRCLProgram "
         "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">"
         "<InitCanon><CommandID>1</CommandID></InitCanon>" +
         middle + "<EndCanon><CommandID>99</CommandID></EndCanon></CRCLProgram>";
}

std::string middle(const std::string& type, int id, const std::string& fields) {
  return "<MiddleCommand xsi:type=\"" + type + "\"><CommandID>" + std::to_string(id) +
         "</CommandID>" + fields + "</MiddleCommand>";
}

CliResult crcl_cli(const ScriptedRobot& robot, const char* verb, const std::string& file,
                   const std::string& timeout = "10") {
  return run_cli({"crcl", verb, file, "--robot", "fanuc", "--timeout", timeout, "--crcl-port",
                  "fanuc=" + std::to_string(robot.port())});
}

TEST(CliCrcl, RunSendsOneCommandAtATimeAndExpandsLoops) {
  ScriptedRobot robot(done, 50);
  const auto file = write_file(
      "program.xml",
      program(middle("LoopBlockStartType", 2, "<LoopName>a</LoopName>") +
              middle("SetEndEffectorType", 3, "<Setting>1.0</Setting>") +
              middle("DwellType", 4, "<DwellTime>0.5</DwellTime>") +
              middle("LoopBlockEndType", 5, "<LoopName>a</LoopName><MaxCount>3</MaxCount>")));
  const auto result = crcl_cli(robot, "run", file);
  ASSERT_EQ(result.exit_code, 0) << result.err << result.out;
  const auto commands = robot.commands();
  ASSERT_EQ(commands.size(), 8U);
  EXPECT_TRUE(std::holds_alternative<crcl::InitCanon>(commands.front().body));
  EXPECT_TRUE(std::holds_alternative<crcl::Dwell>(commands[6].body));
  EXPECT_TRUE(std::holds_alternative<crcl::EndCanon>(commands.back().body));
  // Numbers go on from the robot's last one, each used once; a larger one of the program's is kept.
  for (std::size_t i = 1; i < commands.size(); ++i) {
    EXPECT_GT(commands[i].id, commands[i - 1].id);
  }
  EXPECT_EQ(commands.front().id, 51);
  EXPECT_EQ(commands.back().id, 99);
  EXPECT_NE(result.out.find("8/8 EndCanonType ... CRCL_Done"), std::string::npos) << result.out;
}

TEST(CliCrcl, RunStopsAtTheFirstErrorWithItsDescription) {
  ScriptedRobot robot([](const crcl::Command& command) {
    auto status = done(command);
    if (std::holds_alternative<crcl::SetEndEffector>(command.body)) {
      status.state = crcl::CommandState::kError;
      status.description = "Joint 3 at -171.0 less than limit -170.0";
    }
    return status;
  });
  const auto file =
      write_file("program.xml", program(middle("SetEndEffectorType", 3, "<Setting>1</Setting>")));
  const auto result = crcl_cli(robot, "run", file);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("Joint 3 at -171.0 less than limit -170.0"), std::string::npos);
  EXPECT_NE(result.err.find("SetEndEffectorType"), std::string::npos) << result.err;
  EXPECT_EQ(robot.commands().size(), 2U);
}

TEST(CliCrcl, ACommandThatNeverEndsIsATimeout) {
  ScriptedRobot robot([](const crcl::Command& command) {
    return crcl::CommandStatus{.command_id = command.id, .state = crcl::CommandState::kWorking};
  });
  const auto file = write_file("program.xml", program(""));
  const auto result = crcl_cli(robot, "run", file, "0.2");
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_NE(result.err.find("not done after 0.2 s (CRCL_Working)"), std::string::npos)
      << result.err;
}

TEST(CliCrcl, AnotherClientsCommandIsNotTakenForOurs) {
  ScriptedRobot robot([](const crcl::Command& command) {
    return crcl::CommandStatus{.command_id = command.id + 1000, .state = crcl::CommandState::kDone};
  });
  const auto file = write_file("program.xml", program(""));
  const auto result = crcl_cli(robot, "run", file);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("another client"), std::string::npos) << result.err;
}

TEST(CliCrcl, SendTransmitsTheFileAsItIs) {
  ScriptedRobot robot(done);
  const auto file = write_file("commands.xml", document(crcl::InitCanon{}, 7) + "\n" +
                                                   document(crcl::Dwell{0.25}, 5) +
                                                   document(crcl::GetStatus{}, 5));
  const auto result = crcl_cli(robot, "send", file);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto commands = robot.commands();
  ASSERT_EQ(commands.size(), 2U);
  EXPECT_EQ(commands[0].id, 7);
  EXPECT_EQ(commands[1].id, 5);
  EXPECT_EQ(std::get<crcl::Dwell>(commands[1].body).seconds, 0.25);
  EXPECT_NE(result.out.find("GetStatusType 5: CRCL_Done"), std::string::npos) << result.out;
}

TEST(CliCrcl, FilesThatHoldNoCommandAreNamed) {
  ScriptedRobot robot(done);
  for (const char* content :
       {"", "<CRCLProgram/>", "<CRCLCommandInstance></CRCLCommandInstance>"}) {
    const auto file = write_file("commands.xml", content);
    const auto result = crcl_cli(robot, "send", file);
    EXPECT_EQ(result.exit_code, 2) << content;
    EXPECT_NE(result.err.find(file), std::string::npos) << result.err;
  }
  EXPECT_TRUE(robot.commands().empty());
}

TEST(CliCrcl, AConnectionThatBreaksIsExitCodeThree) {
  auto robot = std::make_unique<ScriptedRobot>(done);
  const std::string port = "fanuc=" + std::to_string(robot->port());
  robot.reset();
  const auto result = run_cli({"crcl", "run", write_file("program.xml", program("")), "--robot",
                               "fanuc", "--crcl-port", port});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.err.find("fanuc"), std::string::npos) << result.err;
}

CliResult pendant(const ScriptedRobot& robot, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "crcl");
  arguments.insert(arguments.end(),
                   {"--robot", "fanuc", "--crcl-port", "fanuc=" + std::to_string(robot.port())});
  return run_cli(arguments);
}

TEST(CliPendant, StatusIsOneLineASample) {
  ScriptedRobot robot(done, 17);
  const auto once = pendant(robot, {"status"});
  ASSERT_EQ(once.exit_code, 0) << once.err;
  EXPECT_EQ(std::count(once.out.begin(), once.out.end(), '\n'), 1) << once.out;
  EXPECT_EQ(once.out.substr(0, 3), "17 ");
  const auto watched = pendant(robot, {"status", "--watch", "--rate", "200", "--count", "4"});
  EXPECT_EQ(std::count(watched.out.begin(), watched.out.end(), '\n'), 4) << watched.out;
  EXPECT_EQ(pendant(robot, {"status", "--rate", "0"}).exit_code, 2);
}

TEST(CliPendant, JogIsRelativeToThePresentPosition) {
  ScriptedRobot robot(done);
  const auto joint = pendant(robot, {"jog", "--joint", "2", "--by", "-1.5", "--speed", "10"});
  ASSERT_EQ(joint.exit_code, 0) << joint.err;
  const auto axis = pendant(robot, {"jog", "--init", "--axis", "z", "--by", "20"});
  ASSERT_EQ(axis.exit_code, 0) << axis.err;
  const auto commands = robot.commands();
  ASSERT_EQ(commands.size(), 3U);
  const auto actuate = std::get<crcl::ActuateJoints>(commands[0].body);
  ASSERT_EQ(actuate.joints.size(), 1U);
  EXPECT_EQ(actuate.joints[0].joint, 2);
  EXPECT_DOUBLE_EQ(actuate.joints[0].position, 20 - 1.5);
  EXPECT_EQ(std::get<crcl::JointSpeedAccel>(actuate.joints[0].details).speed, 10);
  EXPECT_TRUE(std::holds_alternative<crcl::InitCanon>(commands[1].body));
  const auto move = std::get<crcl::MoveTo>(commands[2].body);
  EXPECT_TRUE(move.straight);
  EXPECT_EQ(move.end.pose.point, (crcl::Vector{300, 0, 420}));
}

TEST(CliPendant, InitStopAndGripperSendOneCommand) {
  ScriptedRobot robot(done);
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"init"},
                                                    {"gripper", "close"},
                                                    {"gripper", "0.5"},
                                                    {"stop"},
                                                    {"stop", "--condition", "immediate"}}) {
    const auto result = pendant(robot, arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 1) << result.out;
  }
  const auto commands = robot.commands();
  ASSERT_EQ(commands.size(), 5U);
  EXPECT_TRUE(std::holds_alternative<crcl::InitCanon>(commands[0].body));
  EXPECT_EQ(std::get<crcl::SetEndEffector>(commands[1].body).setting, 0);
  EXPECT_EQ(std::get<crcl::SetEndEffector>(commands[2].body).setting, 0.5);
  EXPECT_EQ(std::get<crcl::StopMotion>(commands[3].body).condition, crcl::StopCondition::kNormal);
  EXPECT_EQ(std::get<crcl::StopMotion>(commands[4].body).condition,
            crcl::StopCondition::kImmediate);
}

TEST(CliPendant, StopReachesTheOthersWhenOneIsGone) {
  ScriptedRobot robot(done);
  auto gone = std::make_unique<ScriptedRobot>(done);
  const std::string port = "fanuc=" + std::to_string(gone->port());
  gone.reset();
  const auto result = run_cli({"crcl", "stop", "--crcl-port", port, "--crcl-port",
                               "motoman=" + std::to_string(robot.port())});
  EXPECT_EQ(result.exit_code, 3) << result.err;
  ASSERT_EQ(robot.commands().size(), 1U);
  EXPECT_TRUE(std::holds_alternative<crcl::StopMotion>(robot.commands()[0].body));
}

TEST(CliPendant, JsonIsTheStatus) {
  ScriptedRobot robot(done, 17);
  const auto json = nlohmann::json::parse(pendant(robot, {"status", "--json"}).out);
  EXPECT_EQ(json.at("robot"), "fanuc");
  EXPECT_EQ(json.at("command_id"), 17);
  EXPECT_EQ(json.at("state"), "CRCL_Done");
  EXPECT_EQ(json.at("tool"), nlohmann::json({300, 0, 400}));
  EXPECT_EQ(json.at("joints").size(), 6U);
  EXPECT_TRUE(json.at("gripper").is_null());
}

TEST(CliPendant, AJogThatDoesNotEndInTimeIsStopped) {
  ScriptedRobot robot([](const crcl::Command& command) {
    const bool stop = std::holds_alternative<crcl::StopMotion>(command.body);
    return crcl::CommandStatus{
        .command_id = command.id,
        .state = stop ? crcl::CommandState::kDone : crcl::CommandState::kWorking};
  });
  const auto jog = pendant(robot, {"jog", "--axis", "x", "--by", "5", "--timeout", "0.2"});
  EXPECT_EQ(jog.exit_code, 4);
  EXPECT_NE(jog.err.find("it has been stopped"), std::string::npos) << jog.err;
  ASSERT_EQ(robot.commands().size(), 2U);
  EXPECT_TRUE(std::holds_alternative<crcl::StopMotion>(robot.commands()[1].body));
}

TEST(CliPendant, JogRefusesUnknownJointsAndAxes) {
  ScriptedRobot robot(done);
  const auto joint = pendant(robot, {"jog", "--joint", "9", "--by", "1"});
  EXPECT_EQ(joint.exit_code, 2);
  EXPECT_NE(joint.err.find("no joint 9"), std::string::npos) << joint.err;
  EXPECT_EQ(pendant(robot, {"jog", "--axis", "w", "--by", "1"}).exit_code, 2);
  EXPECT_EQ(pendant(robot, {"jog", "--axis", "x", "--joint", "1", "--by", "1"}).exit_code, 2);
  EXPECT_EQ(pendant(robot, {"jog", "--joint", "1"}).exit_code, 2);
  EXPECT_TRUE(robot.commands().empty());
}

TEST(CliPendant, ValidateTellsGoodDocumentsFromBad) {
  const auto good = write_file("good.xml", document(crcl::InitCanon{}, 7) + "\n" + program(""));
  const auto ok = run_cli({"crcl", "validate", good});
  EXPECT_EQ(ok.exit_code, 0) << ok.err;
  EXPECT_NE(ok.out.find("2 valid documents"), std::string::npos) << ok.out;
  for (const std::string& text :
       {document(crcl::SetEndEffector{2}, 7), std::string("<CRCLProgram>"), std::string(),
        document(crcl::InitCanon{}, 7) + "<CRCLStatus></CRCLStatus>"}) {
    const auto bad = run_cli({"crcl", "validate", write_file("bad.xml", text)});
    EXPECT_EQ(bad.exit_code, 1) << text;
    EXPECT_NE(bad.err.find("bad.xml: document"), std::string::npos) << bad.err;
  }
  EXPECT_EQ(run_cli({"crcl", "validate", "/no/such/file"}).exit_code, 2);
}

}  // namespace
}  // namespace aprsim::test
