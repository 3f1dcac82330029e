#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "crcl/command_codec.hpp"
#include "tests/unit/crcl/every_command.hpp"
#include "tests/unit/crcl/golden.hpp"
#include "tests/unit/crcl/samples.hpp"

namespace aprsim::crcl {
namespace {

CommandInstance decoded(const std::string& document) {
  Result<CommandInstance> instance = decode_command(document);
  if (!instance) throw std::runtime_error(instance.error().message());
  return *instance;
}

template <typename T>
T body(const std::string& document) {
  return std::get<T>(decoded(document).command.body);
}

Error refused(const std::string& document) {
  const Result<CommandInstance> instance = decode_command(document);
  return instance ? Error{} : instance.error();
}

TEST(Commands, EncodeAsTheGoldenDocuments) {
  for (const auto& [name, instance] : every_command()) {
    EXPECT_EQ(encode_command(instance), golden("command_" + name + ".xml")) << name;
  }
}

TEST(Commands, ComeBackAsTheyWere) {
  for (const auto& [name, instance] : every_command()) {
    EXPECT_EQ(decoded(encode_command(instance)), instance) << name;
  }
}

TEST(Commands, MoveToKeepsEveryBitOfItsNumbers) {
  EXPECT_TRUE(rc::check("numbers survive encoding and decoding", [](double x, double y) {
    RC_PRE(std::isfinite(x) && std::isfinite(y));
    const CommandInstance sent{
        {}, command(MoveTo{true, {{{x, y, -x}, {1, 0, 0}, {0, 1, 0}}, {}}}), {}, {}, {}};
    RC_ASSERT(decode_command(encode_command(sent)).value() == sent);
  }));
}

TEST(Commands, ElementsMayComeInAnyOrderAndUnknownOnesToo) {
  const auto move = body<MoveTo>(
      instance("MoveToType",
               "<Extra><X>9</X></Extra><EndPosition><ZAxis><I>0</I><J>0</J><K>1</K></ZAxis>"
               "<XAxis><K>0</K><J>1</J><I>0</I></XAxis><Point><Z>3</Z><Y>2</Y><X>1</X></Point>"
               "</EndPosition><MoveStraight> 1 </MoveStraight><CommandID>5</CommandID>"));
  EXPECT_TRUE(move.straight);
  EXPECT_EQ(move.end.pose, (Pose{{1, 2, 3}, {0, 1, 0}, {0, 0, 1}}));
}

TEST(Commands, NoCommandIdIsZero) {
  EXPECT_EQ(decoded(instance("InitCanonType", "")).command.id, 0);
}

TEST(Commands, TypeIsFoundByNamespaceWhateverThePrefix) {
  const auto instance = decoded(
      "\xEF\xBB\xBF<?xml version='1.0' encoding='UTF-8'?><!-- c --><CRCLCommandInstance "
      "xmlns:q='http://www.w3.org/2001/XMLSchema-instance' "
      "q:noNamespaceSchemaLocation='http://127.0.0.1:1/none.xsd'>\n<CRCLCommand type='DwellType' "
      "q:type=' InitCanonType '><CommandID>-4</CommandID></CRCLCommand></CRCLCommandInstance>");
  EXPECT_TRUE(std::holds_alternative<InitCanon>(instance.command.body));
  EXPECT_EQ(instance.command.id, -4);
}

TEST(Commands, CharacterDataMayBeInPieces) {
  const auto message = body<Message>(with_id(
      "MessageType", "<Message>a&lt;b<!-- x --><![CDATA[<c>]]>&#xE4;\xF0\x9F\xA6\xBE</Message>"));
  EXPECT_EQ(message.text, "a<b<c>\xC3\xA4\xF0\x9F\xA6\xBE");
}

TEST(Commands, PartialTolerancesAreFine) {
  const auto set = body<SetEndPoseTolerance>(with_id(
      "SetEndPoseToleranceType", "<Tolerance><YPointTolerance>2</YPointTolerance></Tolerance>"));
  EXPECT_EQ(set.tolerance.y_point, 2);
  EXPECT_EQ(set.tolerance.x_point, std::nullopt);
}

TEST(Commands, OutOfRangeFractionsAreKept) {
  EXPECT_EQ(body<SetEndEffector>(with_id("SetEndEffectorType", "<Setting>2.0</Setting>")).setting,
            2);
}

TEST(Commands, AStopStopsWhateverItsCondition) {
  const auto condition = [](const std::string& xml) {
    return body<StopMotion>(with_id("StopMotionType", xml)).condition;
  };
  EXPECT_EQ(condition("<StopCondition>Normal</StopCondition>"), StopCondition::kNormal);
  EXPECT_EQ(condition("<StopCondition>Immediate</StopCondition>"), StopCondition::kImmediate);
  EXPECT_EQ(condition("<StopCondition>Fast</StopCondition>"), StopCondition::kFast);
  EXPECT_EQ(condition("<StopCondition>gently</StopCondition>"), StopCondition::kFast);
  EXPECT_EQ(condition(""), StopCondition::kFast);
}

TEST(Commands, BadValuesNameElementValueAndExpectation) {
  const Error error = refused(with_id(
      "MoveToType", "<EndPosition>" + pose_xml("<X>1</X><Y>2,5</Y><Z>3</Z>") + "</EndPosition>"));
  EXPECT_EQ(error.kind, ErrorKind::kBadValue);
  EXPECT_EQ(error.message(), "MoveToType/EndPosition/Point/Y: '2,5': expected a finite number");
  EXPECT_EQ(error.command_type, "MoveToType");
  EXPECT_EQ(error.command_id, 7);
}

TEST(Commands, NumbersMustBeFinite) {
  for (const char* value : {"NaN", "INF", "-INF", "1e999", ""}) {
    const Error error =
        refused(with_id("DwellType", std::string("<DwellTime>") + value + "</DwellTime>"));
    EXPECT_EQ(error.kind, ErrorKind::kBadValue) << value;
    EXPECT_EQ(error.element, "DwellType/DwellTime") << value;
  }
}

TEST(Commands, MissingElementsAreNamed) {
  EXPECT_EQ(refused(with_id("MoveToType", "")).message(), "MoveToType/EndPosition: missing");
  EXPECT_EQ(refused(with_id("DwellType", "")).message(), "DwellType/DwellTime: missing");
  EXPECT_EQ(refused(with_id("ActuateJointsType", "")).message(),
            "ActuateJointsType/ActuateJoint: missing");
}

TEST(Commands, WaypointsAreCounted) {
  const std::string point = "<Waypoint>" + pose_xml() + "</Waypoint>";
  const auto through = [&](int points, const std::string& count) {
    std::string body = "<MoveStraight>true</MoveStraight>";
    for (int i = 0; i < points; ++i) body += point;
    return with_id("MoveThroughToType", body + count);
  };
  EXPECT_EQ(body<MoveThroughTo>(through(3, "<NumPositions>3</NumPositions>")).waypoints.size(), 3u);
  EXPECT_EQ(body<MoveThroughTo>(through(2, "")).waypoints.size(), 2u);
  EXPECT_EQ(refused(through(3, "<NumPositions>2</NumPositions>")).message(),
            "MoveThroughToType/NumPositions: '2': expected the number of Waypoint elements, 3");
  EXPECT_EQ(refused(through(1, "<NumPositions>1</NumPositions>")).message(),
            "MoveThroughToType/Waypoint: '1 of them': expected 2 or more");
}

TEST(Commands, DegenerateAxesAreRefused) {
  const Error error =
      refused(with_id("MoveToType",
                      "<EndPosition><Point><X>0</X><Y>0</Y><Z>0</Z></Point><XAxis><I>0</I><J>0</J>"
                      "<K>1</K></XAxis><ZAxis><I>0</I><J>0</J><K>1</K></ZAxis></EndPosition>"));
  EXPECT_EQ(error.element, "MoveToType/EndPosition/XAxis");
  EXPECT_EQ(error.value, "0 0 1");
}

TEST(Commands, UnitsMustBeKnown) {
  EXPECT_EQ(refused(with_id("SetLengthUnitsType", "<UnitName>feet</UnitName>")).message(),
            "SetLengthUnitsType/UnitName: 'feet': expected meter, millimeter or inch");
}

TEST(Commands, AbstractAndUnknownTypesAreMalformed) {
  EXPECT_EQ(refused(with_id("CRCLCommandType", "")).kind, ErrorKind::kMalformed);
  EXPECT_EQ(
      refused(with_id("FlyToType", "")).message(),
      "FlyToType: 'FlyToType': unknown xsi:type, expected a command type of CRCLCommands.xsd");
  EXPECT_EQ(refused("<CRCLCommandInstance><CRCLCommand/></CRCLCommandInstance>").kind,
            ErrorKind::kMalformed);
  EXPECT_EQ(refused("<CRCLCommandInstance></CRCLCommandInstance>").kind, ErrorKind::kMalformed);
  EXPECT_EQ(refused("<CRCLStatus></CRCLStatus>").kind, ErrorKind::kMalformed);
  EXPECT_EQ(
      refused(with_id("SetTransSpeedType", "<TransSpeed><Setting>1</Setting></TransSpeed>")).kind,
      ErrorKind::kMalformed);
}

TEST(Commands, ServicesNeedTheirNames) {
  EXPECT_EQ(refused(with_id("EnableSensorType", "")).message(),
            "EnableSensorType/SensorID: missing");
  EXPECT_EQ(refused(with_id("EnableSensorType", "<SensorID> </SensorID>")).message(),
            "EnableSensorType/SensorID: expected a name");
  EXPECT_EQ(refused(with_id("SetRobotParametersType", "")).message(),
            "SetRobotParametersType/ParameterSetting: missing");
  EXPECT_EQ(body<EnableGripper>(with_id("EnableGripperType", "<GripperName> g </GripperName>")),
            (EnableGripper{"g", {}}));
}

TEST(Programs, AreReadInOrder) {
  const std::string xsi = " xmlns:xsi='http://www.w3.org/2001/XMLSchema-instance' xsi:type=";
  const Result<Program> program = decode_program(
      "<CRCLProgram><Name>p</Name><InitCanon><CommandID>1</CommandID></InitCanon><MiddleCommand" +
      xsi + "'MessageType'><CommandID>2</CommandID><Message>hi</Message></MiddleCommand>" +
      "<MiddleCommand" + xsi + "'RunProgramType'><CommandID>3</CommandID><ProgramText>x" +
      "</ProgramText></MiddleCommand><EndCanon><CommandID>4</CommandID></EndCanon></CRCLProgram>");
  ASSERT_TRUE(program) << program.error().message();
  EXPECT_EQ(program->name, "p");
  ASSERT_EQ(program->commands.size(), 4U);
  EXPECT_TRUE(std::holds_alternative<InitCanon>(program->commands[0].body));
  EXPECT_EQ(std::get<Message>(program->commands[1].body).text, "hi");
  EXPECT_EQ(std::get<RunProgram>(program->commands[2].body).text, "x");
  EXPECT_EQ(program->commands[3].id, 4);
}

TEST(Programs, NameTheCommandThatIsWrong) {
  const Result<Program> program = decode_program(
      "<CRCLProgram><InitCanon/><MiddleCommand "
      "xmlns:xsi='http://www.w3.org/2001/XMLSchema-instance' xsi:type='DwellType'>"
      "<CommandID>9</CommandID><DwellTime>soon</DwellTime></MiddleCommand></CRCLProgram>");
  ASSERT_FALSE(program);
  EXPECT_EQ(program.error().message(), "DwellType/DwellTime: 'soon': expected a finite number");
  EXPECT_EQ(program.error().command_id, 9);
}

}  // namespace
}  // namespace aprsim::crcl
