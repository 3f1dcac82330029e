#include <cstdlib>
#include <functional>

#include "clients/aprsim/cli/command_tree.hpp"
#include "clients/aprsim/commands/command_line.hpp"
#include "tests/unit/clients/aprsim/cli_fixture.hpp"
#include "world/api/faults/fault_when.hpp"

namespace aprsim::test {
namespace {

using client::parse_command_line;

template <typename Command>
Command parse_as(std::vector<std::string> arguments) {
  const auto line = parse_command_line(std::move(arguments));
  if (!line) throw std::runtime_error(line.error().text);
  return std::get<Command>(line->command);
}

TEST(CliArguments, CommandsKeepTheirOptions) {
  EXPECT_EQ(parse_as<client::WatchCommand>({"watch", "--rate", "50", "--count", "3"}).rate_hz, 50);
  EXPECT_EQ(parse_as<client::StepCommand>({"step", "250"}).steps, 250U);
  EXPECT_EQ(parse_as<client::StepCommand>({"step"}).steps, 1U);
  EXPECT_EQ(parse_as<client::SpeedCommand>({"speed", "2.5"}).factor, 2.5);
  EXPECT_FALSE(parse_as<client::SpeedCommand>({"speed", "max"}).factor.has_value());
  EXPECT_EQ(parse_as<client::ResetCommand>({"reset", "--seed", "9"}).seed, 9U);
  EXPECT_EQ(parse_as<client::SaveCommand>({"save", "here"}).name, "here");
  EXPECT_EQ(parse_as<client::StatesDeleteCommand>({"states", "delete", "here"}).name, "here");
  EXPECT_EQ(parse_as<client::LoadCommand>({"load", "here"}).name, "here");
  const auto run = parse_as<client::CrclRunCommand>({"crcl", "run", "a.xml", "--robot", "fanuc"});
  EXPECT_EQ(run.file, "a.xml");
  EXPECT_EQ(run.robot, "fanuc");
  const auto demo = parse_as<client::DemoCommand>({"demo", "--robot", "motoman"});
  EXPECT_EQ(demo.robots, std::vector<std::string>{"motoman"});
}

TEST(CliArguments, IntruderIsPlacedOrRemoved) {
  const auto put = parse_as<client::IntruderCommand>({"intruder", "place", "0.5", "-1.75"});
  ASSERT_TRUE(put.xy_m.has_value());
  EXPECT_EQ((*put.xy_m)[1], -1.75);
  EXPECT_EQ(put.size_m[2], 1.75);
  const auto box = parse_as<client::IntruderCommand>(
      {"intruder", "place", "0", "0", "--size", "0.1", "0.2", "0.3"});
  EXPECT_EQ(box.size_m[1], 0.2);
  EXPECT_FALSE(parse_as<client::IntruderCommand>({"intruder", "remove"}).xy_m.has_value());
}

TEST(CliArguments, AFaultHasATargetParametersAndATime) {
  const auto leak =
      parse_as<client::FaultInjectCommand>({"fault", "inject", "gripper-leak", "fanuc", "--over",
                                            "5", "--share", "0.2", "--at", "3", "--for", "2.5"});
  EXPECT_EQ(leak.kind, "gripper-leak");
  EXPECT_EQ(leak.target, "fanuc");
  EXPECT_EQ(leak.parameters, (std::map<std::string, double>{{"over", 5}, {"share", 0.2}}));
  EXPECT_EQ(leak.at_s, 3);
  EXPECT_EQ(leak.for_s, 2.5);
  EXPECT_FALSE(leak.when);
  const auto jam = parse_as<client::FaultInjectCommand>({"fault", "inject", "belt-jam"});
  EXPECT_EQ(jam.target, "");
  EXPECT_FALSE(jam.at_s || jam.for_s || jam.when);
  EXPECT_EQ(parse_as<client::FaultEndCommand>({"fault", "end", "7"}).id, 7U);
}

TEST(CliArguments, FaultTriggers) {
  const auto when = [](const std::string& text) {
    const auto parsed = faults::parse_when(text);
    if (!parsed) throw std::runtime_error(parsed.error());
    return *parsed;
  };
  const auto placed = std::get<faults::WhenPlaced>(when("placed:sku_part_large_gear:fanuc"));
  EXPECT_EQ(placed.type, "sku_part_large_gear");
  EXPECT_EQ(placed.robot, "fanuc");
  EXPECT_EQ(std::get<faults::WhenPlaced>(when("placed:sku_part_large_gear")).robot, "");
  EXPECT_EQ(std::get<faults::WhenGrasped>(when("grasp:fanuc")).count, 1U);
  EXPECT_EQ(std::get<faults::WhenGrasped>(when("grasp:fanuc:3")).count, 3U);
  EXPECT_EQ(std::get<faults::WhenBeamBroken>(when("beam:upstream")).eye, "upstream");
  EXPECT_EQ(std::get<faults::WhenReported>(when("event:order-submitted")).event, "order-submitted");
  const auto joint = std::get<faults::WhenCrossing>(when("joint-position:motoman:7<-0.5"));
  EXPECT_EQ(joint.robot, "motoman");
  EXPECT_EQ(joint.joint, 7U);
  EXPECT_FALSE(joint.above);
  EXPECT_EQ(joint.limit, -0.5);
  EXPECT_TRUE(std::get<faults::WhenCrossing>(when("belt-travel>1")).above);
  for (const char* bad :
       {"", "placed", "placed:", "placed:a:b:c", "grasp", "grasp:fanuc:0", "grasp:fanuc:x", "beam",
        "event:", "soon", "belt-travel>", "belt-travel>far", "belt-travel:fanuc>1", "mood>1",
        "tool-force>1", "joint-position:fanuc>1", "joint-position:fanuc:0>1"}) {
    EXPECT_FALSE(faults::parse_when(bad)) << bad;
  }
}

TEST(CliArguments, BeltSpeedIsMetresPerSecondOrPercent) {
  const auto metres = parse_as<client::ConveyorSetCommand>(
      {"conveyor", "set", "--speed", "0.15", "--direction", "reverse"});
  EXPECT_EQ(metres.speed_m_s, 0.15);
  EXPECT_EQ(metres.forward, false);
  const auto percent = parse_as<client::ConveyorSetCommand>({"conveyor", "set", "--speed", "50%"});
  EXPECT_EQ(percent.speed_percent, 50);
  EXPECT_FALSE(percent.speed_m_s.has_value());
  EXPECT_TRUE(parse_as<client::ConveyorSetCommand>({"conveyor", "set", "--stop"}).stop);
}

TEST(CliArguments, EndpointsMayFollowTheCommand) {
  const auto line =
      parse_command_line({"status", "--host", "cell", "--grpc-port", "5", "--crcl-port", "r2=6"});
  ASSERT_TRUE(line.has_value());
  EXPECT_EQ(line->endpoints.host, "cell");
  EXPECT_EQ(line->endpoints.grpc, 5);
  EXPECT_EQ(line->endpoints.crcl.at("r2"), 6);
}

TEST(CliArguments, WrongArgumentsAreExitCodeTwo) {
  const std::vector<std::vector<std::string>> cases = {
      {},
      {"dance"},
      {"speed", "-1"},
      {"speed", "nan"},
      {"speed", "2x"},
      {"step", "0"},
      {"conveyor", "set", "--speed", "101%"},
      {"conveyor", "set", "--speed", "-0.1"},
      {"conveyor", "set", "--speed", "fast"},
      {"conveyor", "set", "--direction", "up"},
      {"conveyor", "set", "--stop", "--speed", "1%"},
      {"crcl", "run", "a.xml"},
      {"status", "--grpc-port", "70000"},
      {"status", "--crcl-port", "fanuc"},
  };
  for (const auto& arguments : cases) {
    const auto result = run_cli(arguments);
    EXPECT_EQ(result.exit_code, 2) << testing::PrintToString(arguments);
    EXPECT_FALSE(result.err.empty());
    EXPECT_TRUE(result.out.empty()) << result.out;
  }
  EXPECT_NE(run_cli({"speed", "-1"}).err.find("'-1'"), std::string::npos);
}

TEST(CliArguments, JsonMayComeBeforeTheCommand) {
  const auto line = parse_command_line({"--json", "status"});
  ASSERT_TRUE(line.has_value()) << line.error().text;
  EXPECT_TRUE(line->json);
  EXPECT_TRUE(parse_command_line({"status", "--json"})->json);
  EXPECT_FALSE(parse_command_line({"status"})->json);
  // Where there is no JSON, it is refused as it is after the command.
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"--json", "manual"}, {"--json", "completion", "bash"}}) {
    EXPECT_EQ(run_cli(arguments).exit_code, 2) << arguments[1];
  }
}

TEST(CliArguments, ARunNeedsAnEnd) {
  const auto result = run_cli({"run"});
  EXPECT_EQ(result.exit_code, 2);
  for (const char* end : {"--time", "--event", "--beyond", "--steps"}) {
    EXPECT_NE(result.err.find(end), std::string::npos) << result.err;
  }
}

TEST(CliArguments, MistypedFaultKindsGetSuggestions) {
  const auto result = run_cli({"fault", "inject", "belt-jm"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("did you mean 'belt-jam'?"), std::string::npos) << result.err;
}

TEST(CliArguments, TextsThatAreNoUtf8AreRefusedWithTheirField) {
  const auto result = run_cli({"save", "x\xff", "--grpc-port", "1"});
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_NE(result.err.find("\"x\\xff\", expected UTF-8"), std::string::npos) << result.err;
}

TEST(CliArguments, MistypedArgumentsGetSuggestions) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"stauts"}, "unknown command 'stauts'; did you mean 'status'?"},
      {{"dmo"}, "did you mean 'demo'?"},
      {{"conv"}, "did you mean 'conveyor'?"},
      {{"crlc", "jog", "--robot", "fanuc"}, "did you mean 'crcl'?"},
      {{"crcl", "gog", "--robot", "fanuc", "--by", "1"}, "did you mean 'jog'?"},
      {{"crcl", "jog", "--robt", "fanuc", "--axs", "x", "--by", "1"},
       "unknown option '--robt'; did you mean '--robot'?"},
      {{"crcl", "jog", "--robot", "fanuc", "--axs=x", "--by", "1"}, "did you mean '--axis'?"},
      {{"status", "--grpc-prot", "5"}, "did you mean '--grpc-port'?"},
  };
  for (const auto& [arguments, sentence] : cases) {
    const auto result = run_cli(arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find(sentence), std::string::npos) << result.err;
    EXPECT_EQ(result.err.rfind("aprsim: ", 0), 0U) << result.err;
  }
  EXPECT_EQ(run_cli({"xylophone"}).err.find("did you mean"), std::string::npos);
  EXPECT_NE(run_cli({"crcl"}).err.find("a command is missing: status, init, stop"),
            std::string::npos);
  EXPECT_NE(run_cli({"crcl", "jgo"}).err.find("Run 'aprsim crcl --help'"), std::string::npos);
}

TEST(CliArguments, AJogNamesWhatMoves) {
  const auto jog = run_cli({"crcl", "jog", "--robot", "fanuc", "--by", "1"});
  EXPECT_EQ(jog.exit_code, 2);
  EXPECT_NE(jog.err.find("--axis"), std::string::npos) << jog.err;
  EXPECT_NE(jog.err.find("--joint"), std::string::npos) << jog.err;
}

TEST(CliArguments, RobotCommandsKeepTheirOptions) {
  EXPECT_EQ(parse_as<client::CrclInitCommand>({"crcl", "init", "--robot", "a"}).robot, "a");
  const auto stop = parse_as<client::CrclStopCommand>(
      {"crcl", "stop", "--robot", "a", "--robot", "b", "--condition", "immediate"});
  EXPECT_EQ(stop.robots, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(stop.condition, crcl::StopCondition::kImmediate);
  EXPECT_TRUE(parse_as<client::CrclStopCommand>({"crcl", "stop"}).robots.empty());
  for (const auto& [text, setting] :
       {std::pair("open", 1.0), std::pair("close", 0.0), std::pair("0.25", 0.25)}) {
    EXPECT_EQ(
        parse_as<client::CrclGripperCommand>({"crcl", "gripper", text, "--robot", "a"}).setting,
        setting);
  }
  EXPECT_EQ(parse_as<client::CrclJogCommand>(
                {"crcl", "jog", "--robot", "a", "--axis", "z", "--by", "-20"})
                .axis,
            'z');
}

TEST(CliArguments, EveryCommandAndOptionIsExplained) {
  const std::function<void(const client::CommandInfo&)> check =
      [&](const client::CommandInfo& command) {
        EXPECT_FALSE(command.help.empty()) << command.path;
        for (const auto& option : command.options) {
          EXPECT_FALSE(option.help.empty()) << command.path;
          EXPECT_TRUE(option.positional || !option.names.empty()) << command.path;
          // The parser's own name of a type is no placeholder.
          EXPECT_EQ(option.value.find("TEXT"), std::string::npos) << command.path;
          EXPECT_EQ(option.value.find("FLOAT"), std::string::npos) << command.path;
        }
        for (const auto& sub : command.commands) check(sub);
      };
  check(client::command_tree());
}

TEST(CliArguments, HelpAndVersionAreExitCodeZero) {
  const auto help = run_cli({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_NE(help.out.find("conveyor"), std::string::npos);
  EXPECT_EQ(run_cli({"--version"}).exit_code, 0);
  EXPECT_NE(run_cli({"demo", "--help"}).out.find("--robot"), std::string::npos);
}

TEST(Endpoints, PortsFileGivesAllPorts) {
  const auto path = write_file(
      "ports.json", R"({"crcl.fanuc": 1001, "modbus": 1002, "grpc": 1003, "web": 1, "pid": 7})");
  const auto endpoints = client::read_ports_file(path);
  ASSERT_TRUE(endpoints.has_value()) << endpoints.error().message;
  EXPECT_EQ(endpoints->grpc, 1003);
  EXPECT_EQ(endpoints->modbus, 1002);
  EXPECT_EQ(client::crcl_port(*endpoints, "fanuc"), 1001);
  // A robot that the daemon does not have is not at its default port either.
  const auto missing = client::crcl_port(*endpoints, "motoman");
  ASSERT_FALSE(missing.has_value());
  EXPECT_NE(missing.error().message.find("fanuc"), std::string::npos);
}

TEST(Endpoints, SingleChoicesWinOverFileAndFileOverDefaults) {
  const auto path = write_file("ports.json", R"({"grpc": 1003, "modbus": 1002})");
  client::EndpointChoice choice;
  choice.ports_file = path;
  choice.modbus = 77;
  const auto endpoints = client::find_endpoints(choice);
  ASSERT_TRUE(endpoints.has_value());
  EXPECT_EQ(endpoints->grpc, 1003);
  EXPECT_EQ(endpoints->modbus, 77);
  EXPECT_EQ(endpoints->host, "127.0.0.1");
}

TEST(Endpoints, EnvironmentNamesTheFileAndDefaultsComeLast) {
  ASSERT_EQ(unsetenv("APRSIM_PORTS_FILE"), 0);
  const auto defaults = client::find_endpoints({});
  ASSERT_TRUE(defaults.has_value());
  EXPECT_EQ(defaults->grpc, 50051);
  EXPECT_EQ(defaults->modbus, 1502);
  EXPECT_EQ(client::crcl_port(*defaults, "fanuc"), 64444);
  EXPECT_EQ(client::crcl_port(*defaults, "motoman"), 64445);
  const auto path = write_file("ports.json", R"({"grpc": 1234})");
  ASSERT_EQ(setenv("APRSIM_PORTS_FILE", path.c_str(), 1), 0);
  const auto named = client::find_endpoints({});
  unsetenv("APRSIM_PORTS_FILE");
  ASSERT_TRUE(named.has_value());
  EXPECT_EQ(named->grpc, 1234);
}

TEST(Endpoints, OfflineCommandsNeedNoPortsFile) {
  ASSERT_EQ(setenv("APRSIM_PORTS_FILE", "/no/such", 1), 0);
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"conveyor", "map"},
                                                    {"completion", "zsh"},
                                                    {"fault", "kinds"},
                                                    {"manual"}}) {
    EXPECT_EQ(run_cli(arguments).exit_code, 0) << arguments.front();
  }
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"replay", "/no/run"},
        {"trace", "show", "/no/run"},
        {"merge", "/no/batch", "--out", "/no/merged"},
        {"report", "diff", "/no/batch", "/no/merged"}}) {
    EXPECT_EQ(run_cli(arguments).err.find("ports file"), std::string::npos) << arguments.front();
  }
  EXPECT_NE(run_cli({"status"}).err.find("ports file"), std::string::npos);
  EXPECT_EQ(run_cli({"status"}).exit_code, 2);
  unsetenv("APRSIM_PORTS_FILE");
}

TEST(Endpoints, BadFilesAreNamed) {
  for (const char* content : {"", "[1]", "{\"grpc\": ", R"({"grpc": 0})", R"({"grpc": "x"})",
                              R"({"modbus": 65536})", R"({"crcl.fanuc": 1.5})"}) {
    const auto path = write_file("ports.json", content);
    const auto result = run_cli({"status", "--ports-file", path});
    EXPECT_EQ(result.exit_code, 2) << content;
    EXPECT_NE(result.err.find(path), std::string::npos) << result.err;
  }
  EXPECT_NE(run_cli({"status", "--ports-file", "/no/such"}).err.find("/no/such"),
            std::string::npos);
}

}  // namespace
}  // namespace aprsim::test
