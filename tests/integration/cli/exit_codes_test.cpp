#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/cli/command_tree.hpp"
#include "tests/integration/cli/cli_commands.hpp"
#include "tests/support/capture_file.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/journal_file.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::test {
namespace {

using Arguments = std::vector<std::string>;

struct Row {
  std::string command;  ///< its words, as the command tree has them
  Arguments arguments;
  bool alone = false;      ///< needs no daemon
  bool elsewhere = false;  ///< its success is another test's, at a pace of its own
};

std::string state_file() {
  static const TemporaryDirectory directory;
  return directory.path() + "/there.state";
}

std::string broken_journal() {
  static const TemporaryDirectory directory;
  return directory.write("broken.journal", "no journal");
}

/// The journal of a short run.
std::string recorded_run() {
  static const TemporaryDirectory directory;
  static const std::string file = [] {
    const std::string journal = directory.path() + "/run.journal";
    DaemonProcess daemon({"--speed", "stepped", "--journal", journal});
    run_aprsim(daemon, {"step", "1000"});
    const bool written = eventually(
        [&] {
          std::error_code none;
          const auto size = std::filesystem::file_size(journal, none);
          return !none && size > 10'000;
        },
        std::chrono::seconds(30));
    EXPECT_TRUE(written) << journal;
    return journal;
  }();
  return file;
}

/// A journal and a capture of a short talk with a robot, and where to write.
struct TraceFiles {
  TraceFiles() {
    JournalFile recorded;
    recorded.command("crcl.fanuc", 1, 1, "InitCanonType", "");
    recorded.write(journal);
    CaptureFile captured;
    CapturedConnection robot(captured, 50000, 64444);
    robot.open(0);
    robot.sends(0.1, JournalFile::instance(1, "InitCanonType", ""));
    std::ofstream(capture, std::ios::binary) << captured.bytes();
  }
  const TemporaryDirectory directory;
  const std::string journal = directory.path() + "/run.journal";
  const std::string capture = directory.path() + "/lab.pcap";
  const std::string out = directory.path() + "/out";
};
const TraceFiles& trace_files() {
  static const TraceFiles files;
  return files;
}

/// For the results of commands, as long as the tests run.
std::string place(const std::string& name) {
  static const TemporaryDirectory directory;
  return directory.path() + '/' + name;
}

/// One run of each command that succeeds, in an order in which each can.
std::vector<Row> every_command() {
  return {{"status", {"--bodies"}},
          {"watch", {"--count", "1"}},
          {"events", {"--past", "--count", "1"}},
          {"pause", {}},
          {"step", {"3"}},
          {"resume", {}},
          {"speed", {"max"}},
          {"save", {"here"}},
          {"load", {"here"}},
          {"save", {"there", "--file", state_file()}},
          {"load", {"--file", recorded_run()}},  // whose first checkpoint is a state
          {"replay", {recorded_run()}, true},
          {"states list", {}},
          {"states delete", {"here"}},
          {"incident", {"--last", "5s", "--file", "/dev/null"}},
          {"intruder place", {"0", "-1.75"}},
          {"intruder remove", {}},
          {"device set", {"scale", "full_kg", "1"}, false, true},
          {"crcl init", {"--robot", "fanuc"}},
          {"crcl status", {"--robot", "fanuc"}},
          {"crcl gripper", {"close", "--robot", "fanuc"}},
          {"crcl jog", {"--robot", "fanuc", "--joint", "1", "--by", "1"}},
          {"crcl stop", {}},
          {"crcl send", {example("grip.xml"), "--robot", "fanuc"}},
          {"crcl run", {example("wave.xml"), "--robot", "fanuc"}},
          {"crcl validate", {example("wave.xml")}, true},
          {"conveyor status", {}},
          {"conveyor set", {"--speed", "10%", "--direction", "forward"}},
          {"conveyor map", {}, true},
          {"modbus map", {"line"}, false, true},
          {"conform crcl", {"--robot", "fanuc"}, false, true},
          {"conform modbus", {}},
          {"conform clauses", {}, true},
          {"reset", {"--seed", "3", "--scene", "aprs"}},
          {"scene types", {}},
          {"scene list", {}},
          {"scene show", {}},
          {"scene spawn", {"sku_part_large_gear", "spare", "--at", "0.3", "-1", "1.2"}},
          {"scene move", {"spare", "--at", "0.3", "-1", "1.3"}},
          {"scene set", {"physics.friction.gear_tray", "0.3"}},
          {"save", {"changed", "--file", place("changed.state")}},
          {"scene remove", {"spare"}},
          {"load", {"--file", place("changed.state")}},
          {"scene remove", {"spare"}},
          {"run", {"--steps", "3"}},
          {"resume", {}},
          {"fault kinds", {}, true},
          {"fault inject", {"belt-slip", "--share", "0.8", "--for", "600"}},
          {"fault list", {}},
          {"fault event", {"order-submitted"}},
          {"fault end", {"1"}},
          {"scene check", {"aprs"}, true},
          {"scene diff", {"aprs", "aprs"}, true},
          {"scene format", {"aprs"}, true},
          {"scene schema", {"--types"}, true},
          {"scenario list", {}, true},
          {"scenario check", {"clean_2017"}, true},
          {"scenario diff", {"clean_2017", "clean_2017"}, true},
          {"scenario format", {"clean_2017"}, true},
          {"scenario schema", {}, true},
          // A controller that does nothing fills no kit.
          {"scenario run", {"cannot_be_done", "--controller", "true"}, true},
          {"trace diff", {trace_files().journal, trace_files().journal}, true},
          {"trace import", {trace_files().capture, "--out", trace_files().out + ".journal"}, true},
          {"trace show", {trace_files().journal}, true},
          {"trace export", {trace_files().journal, "--csv", trace_files().out}, true},
          {"batch", {"pick", "--seeds", "1", "--journals", "0", "--out", place("batch")}, true},
          {"merge", {place("batch"), "--out", place("merged")}, true},
          {"report diff", {place("batch"), place("merged")}, true},
          {"demo", {"--robot", "fanuc"}},
          {"camera fit", {"--help"}, true},
          {"calibrate", {"--help"}, true},
          {"compare", {"--help"}, true},
          {"completion", {"bash"}, true},
          {"manual", {}, true}};
}

Arguments words(const std::string& text) {
  std::istringstream in(text);
  return {std::istream_iterator<std::string>(in), {}};
}

Arguments line_of(const Row& row, const Arguments& more = {}) {
  Arguments line = words(row.command);
  line.insert(line.end(), row.arguments.begin(), row.arguments.end());
  line.insert(line.end(), more.begin(), more.end());
  return line;
}

/// The commands that do something, by their words.
void collect(const client::CommandInfo& command, std::vector<client::CommandInfo>& out) {
  if (command.commands.empty()) out.push_back(command);
  for (const auto& sub : command.commands) collect(sub, out);
}

std::vector<client::CommandInfo> leaves() {
  std::vector<client::CommandInfo> out;
  collect(client::command_tree(), out);
  return out;
}

std::string words_of(const client::CommandInfo& command) {
  return command.path.substr(command.path.find(' ') + 1);
}

bool offers_json(const std::string& name) {
  for (const auto& leaf : leaves()) {
    if (words_of(leaf) != name) continue;
    return std::ranges::any_of(leaf.options, [](const client::OptionInfo& option) {
      return std::ranges::find(option.names, "--json") != option.names.end();
    });
  }
  return false;
}

/// Python programs, which have tests of their own, only show their help here.
bool tells_json(const Row& row) {
  return offers_json(row.command) && row.arguments != Arguments{"--help"};
}

ProcessResult run_alone(const Arguments& arguments) {
  Arguments argv = {std::string(APRSIM_BIN_DIR) + "/aprsim"};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  return run_process(argv);
}

TEST(ExitCodes, EveryCommandIsTried) {
  const auto rows = every_command();
  for (const auto& leaf : leaves()) {
    EXPECT_NE(std::ranges::find(rows, words_of(leaf), &Row::command), rows.end())
        << "no row for " << leaf.path;
  }
}

TEST(ExitCodes, ZeroWhenDoneAndValidJson) {
  DaemonProcess daemon({"--speed", "max"});
  for (const bool json : {false, true}) {
    for (const auto& row : every_command()) {
      if (row.elsewhere || (json && !tells_json(row))) continue;
      const auto line = line_of(row, json ? Arguments{"--json"} : Arguments{});
      auto result = run_aprsim(daemon, line);
      // On a machine with much else to do the cell may lose its pace, which status reports.
      if (row.command == "status") {
        EXPECT_TRUE(eventually([&] { return (result = run_aprsim(daemon, line)).exit_code == 0; },
                               std::chrono::seconds(30)));
      }
      EXPECT_EQ(result.exit_code, 0) << row.command << "\n" << result.out << result.err;
      EXPECT_EQ(result.err, "") << row.command;
      if (!json) continue;
      std::istringstream lines(result.out);
      int count = 0;
      for (std::string object; std::getline(lines, object); ++count) {
        EXPECT_TRUE(nlohmann::json::parse(object, nullptr, false).is_object())
            << row.command << ": " << object;
      }
      EXPECT_GE(count, 1) << row.command;
    }
  }
}

TEST(ExitCodes, EveryKeyOfTheJsonIsInTheManual) {
  DaemonProcess daemon({"--speed", "max"});
  const std::string manual = run_alone({"manual"}).out;
  for (const auto& row : every_command()) {
    // Those two are protobuf's, as the manual says.
    if (!tells_json(row) || row.command == "status" || row.command == "watch") continue;
    std::istringstream lines(run_aprsim(daemon, line_of(row, {"--json"})).out);
    for (std::string line; std::getline(lines, line);) {
      const auto object = nlohmann::json::parse(line);
      for (const auto& [key, value] : object.items()) {
        EXPECT_NE(manual.find(key), std::string::npos) << row.command << ": " << key;
      }
    }
  }
}

TEST(ExitCodes, OneWhenRefused) {
  DaemonProcess daemon({"--speed", "max"});
  const TemporaryDirectory directory;
  const std::string broken = directory.write("broken.xml", "<CRCLProgram></CRCLProgram>");
  const std::string misspelt = directory.write("misspelt.yaml", "sed:   1\n");
  const std::vector<Arguments> cases = {
      {"step", "2"},  // while it runs
      {"load", "nothing"},
      {"watch", "--rate", "5000"},
      {"intruder", "place", "0", "-1.75", "--size", "1000", "1000", "1000"},
      {"fault", "inject", "robot-slow"},  // of which
      {"fault", "inject", "robot-slow", "r2d2"},
      {"fault", "inject", "robot-slow", "fanuc", "--share", "2"},
      {"fault", "inject", "protective-stop", "fanuc", "--for", "3"},
      {"fault", "inject", "belt-jam", "--when", "beam:nowhere"},
      {"fault", "end", "4711"},
      {"crcl", "gripper", "open", "--robot", "fanuc"},  // before InitCanon
      {"crcl", "jog", "--robot", "fanuc", "--init", "--joint", "1", "--by", "100000"},
      {"crcl", "jog", "--robot", "fanuc", "--init", "--axis", "z", "--by", "100000"},
      {"crcl", "validate", broken},
      {"scene", "check", misspelt},
      {"scenario", "check", misspelt},
      {"scene", "diff", "aprs", "aprs_2024"},
      {"scene", "format", "--check", misspelt},
  };
  for (const auto& arguments : cases) {
    const auto result = run_aprsim(daemon, arguments);
    EXPECT_EQ(result.exit_code, 1) << testing::PrintToString(arguments) << result.out;
    EXPECT_EQ(result.err.rfind("aprsim: ", 0), 0U) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  }
}

TEST(ExitCodes, OneWhenTheBeltIsInAFault) {
  DaemonProcess daemon({"--speed", "max", "--scene", "fanuc_only"});
  const auto absent = run_aprsim(daemon, {"conveyor", "status"});
  EXPECT_EQ(absent.exit_code, 1) << absent.out;
  EXPECT_NE(absent.err.find("no conveyor"), std::string::npos) << absent.err;
}

TEST(ExitCodes, TwoWhenTheArgumentsAreWrong) {
  DaemonProcess daemon;
  for (const auto& leaf : leaves()) {
    Arguments arguments = words(words_of(leaf));
    arguments.push_back("--no-such-option");
    EXPECT_EQ(run_aprsim(daemon, arguments).exit_code, 2) << leaf.path;
  }
  const std::vector<Arguments> cases = {
      {},
      {"dance"},
      {"crcl"},
      {"conveyor"},
      {"intruder"},
      {"conveyor", "set"},
      {"conveyor", "set", "--full-scale", "nan", "--speed", "0.1"},
      {"crcl", "jog", "--robot", "fanuc", "--by", "1"},
      {"crcl", "jog", "--robot", "fanuc", "--axis", "x", "--by", "nan"},
      {"crcl", "jog", "--robot", "fanuc", "--axis", "x", "--by", "inf"},
      {"crcl", "jog", "--robot", "fanuc", "--axis", "x", "--by", "1", "--speed", "nan"},
      {"crcl", "jog", "--robot", "fanuc", "--axis", "x", "--by", "1", "--timeout", "1e300"},
      {"crcl", "jog", "--robot", "", "--axis", "x", "--by", "1"},
      {"crcl", "jog", "--robot", "fanuc", "--joint", "99", "--by", "1"},
      {"crcl", "gripper", "ajar", "--robot", "fanuc"},
      {"crcl", "gripper", "1.5", "--robot", "fanuc"},
      {"crcl", "gripper", "--robot", "fanuc"},
      {"crcl", "stop", "--condition", "soon"},
      {"crcl", "stop", "--robot", "r2d2"},
      {"crcl", "status", "--robot", "fanuc", "--count", "3"},
      {"crcl", "status", "--robot", "fanuc", "--rate", "3"},
      {"crcl", "init", "--robot", "r2d2"},
      {"crcl", "send", "/no/such", "--robot", "fanuc"},
      {"crcl", "run", "/no/such", "--robot", "fanuc"},
      {"crcl", "validate", "/no/such"},
      {"demo", "--robot", "r2d2"},
      {"intruder", "place", "0"},
      {"intruder", "place", "nan", "0"},
      {"intruder", "place", "0", "0", "--size", "1", "1", "-1"},
      {"save", ""},
      {"load"},
      {"load", "--file", "/no/such"},
      {"replay"},
      {"replay", "/no/such"},
      {"replay", broken_journal()},
      {"replay", recorded_run(), "--from", "soon"},
      {"replay", recorded_run(), "--from", "4711:1"},
      {"replay", recorded_run(), "--to", "-1"},
      {"replay", recorded_run(), "--speed", "0"},
      {"replay", recorded_run(), "--any-port"},
      {"fault"},
      {"fault", "inject"},
      {"fault", "inject", "gremlins"},
      {"fault", "inject", "belt-jam", "--share", "0.5"},
      {"fault", "inject", "belt-slip", "--share", "nan"},
      {"fault", "inject", "belt-jam", "--at", "-1"},
      {"fault", "inject", "belt-jam", "--for", "0"},
      {"fault", "inject", "belt-jam", "--at", "1", "--when", "beam:entry"},
      {"fault", "inject", "belt-jam", "--when", "grasp"},
      {"fault", "inject", "belt-jam", "--when", "tool-force:fanuc"},
      {"fault", "inject", "belt-jam", "--when", "tool-force>20"},
      {"fault", "inject", "belt-jam", "--when", "joint-position:fanuc:0>1"},
      {"fault", "end", "last"},
      {"fault", "event", ""},
      {"scenario"},
      {"scenario", "check"},
      {"scenario", "check", "clean_1917"},
      {"scene", "check"},
      {"scene", "check", "arps"},
      {"scene", "check", "/no/such.yaml"},
      {"scene", "diff", "aprs"},
      {"scene", "diff", "aprs", "arps"},
      {"scene", "format"},
      {"scene", "format", "aprs", "--check", "--write"},
      {"scenario", "schema", "--types"},
      {"scenario", "run", "/no/such.yaml"},
      {"scenario", "run", "clean_2017", "--speed", "0"},
      {"scenario", "run", "clean_2017", "--virtual", "--speed", "2"},
      {"scenario", "run", "clean_2017", "--virtual", "--controller", "none"},
      {"scenario", "run", "clean_2017", "--attach", "--journal", "/tmp/j"},
      {"batch"},
      {"batch", "pick", "--seeds", "1..3"},
      {"batch", "pick", "--out", "/tmp/never"},
      {"batch", "pick", "--seeds", "3..1", "--out", "/tmp/never"},
      {"batch", "pick", "--seeds", "1..3", "--shard", "3/3", "--out", "/tmp/never"},
      {"batch", "pick", "--seeds", "1..3", "--jobs", "0", "--out", "/tmp/never"},
      {"batch", "pick", "--seeds", "1..3", "--reuse-controller", "--out", "/tmp/never"},
      {"batch", "no_such", "--seeds", "1..3", "--out", "/tmp/never"},
      {"batch", "pick", "--seeds", "1..3", "--out", "/proc/never"},
      {"merge", "/no/such", "--out", "/tmp/never"},
      {"merge", "/no/such"},
      {"report"},
      {"report", "diff", "/no/such", "/no/such"},
      {"report", "diff", "/no/such"},
      {"report", "diff", "/no/such", "/no/such", "--level", "2"},
      {"scenario", "run", "clean_2017", "--controller", ""},
      {"trace"},
      {"trace", "diff", trace_files().journal},
      {"trace", "diff", trace_files().journal, "/no/such"},
      {"trace", "diff", trace_files().capture, trace_files().journal},
      {"trace", "diff", trace_files().journal, trace_files().journal, "--tolerance", "x=1"},
      {"trace", "diff", trace_files().journal, trace_files().journal, "--tolerance", "end_mm=-1"},
      {"trace", "import", trace_files().journal, "--out", trace_files().out},
      {"trace", "import", trace_files().capture, "--out", "/no/such/directory/file"},
      {"trace", "import", trace_files().capture, "--out", trace_files().out, "--port", "grpc=1"},
      {"trace", "show", "/no/such"},
      {"trace", "export", trace_files().journal},
      {"trace", "export", trace_files().journal, "--html", trace_files().out + ".html"},
      {"trace", "export", "/no/such", "--csv", trace_files().out},
      {"step", "0"},
      {"speed", "nan"},
      {"completion", "fish"},
      {"manual", "--json"},
      {"status", "--grpc-port", "0"},
      {"status", "--host", ""},
      {"status", "--ports-file", ""},
      {"status", "--ports-file", "/no/such"},
  };
  for (const auto& arguments : cases) {
    const auto result = run_aprsim(daemon, arguments);
    EXPECT_EQ(result.exit_code, 2) << testing::PrintToString(arguments) << result.out;
    EXPECT_EQ(result.err.rfind("aprsim: ", 0), 0U) << result.err;
    EXPECT_EQ(result.out, "") << testing::PrintToString(arguments);
  }
}

TEST(ExitCodes, ThreeWithoutDaemon) {
  const TemporaryDirectory directory;
  // The ports file of a daemon that has ended.
  std::string ports;
  {
    const DaemonProcess daemon;
    std::ifstream in(daemon.ports_file());
    ports.assign(std::istreambuf_iterator<char>(in), {});
  }
  const auto file = directory.write("ports.json", ports);
  for (const auto& row : every_command()) {
    auto arguments = line_of(row);
    arguments.insert(arguments.end(), {"--ports-file", file});
    // Its input is read before the daemon is contacted.
    const std::string& last = row.arguments.empty() ? row.command : row.arguments.back();
    if (row.command == "load" && last.starts_with('/') && !std::filesystem::exists(last)) {
      std::ofstream(last) << "a state";
    }
    const auto result = run_alone(arguments);
    EXPECT_EQ(result.exit_code, row.alone ? 0 : 3) << row.command << result.err;
    if (row.alone) continue;
    // crcl stop reports the first robot that it cannot reach.
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_EQ(result.out, "") << row.command;
  }
}

TEST(ExitCodes, FourOnTimeout) {
  DaemonProcess daemon;
  const TemporaryDirectory directory;
  const auto file = directory.write(
      "dwell.xml",
      "<CRCLCommandInstance xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\"><CRCLCommand "
      "xsi:type=\"InitCanonType\"><CommandID>1</CommandID></CRCLCommand></CRCLCommandInstance>"
      "<CRCLCommandInstance xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\"><CRCLCommand "
      "xsi:type=\"DwellType\"><CommandID>2</CommandID><DwellTime>60</DwellTime></CRCLCommand>"
      "</CRCLCommandInstance>");
  const auto result =
      run_aprsim(daemon, {"crcl", "send", file, "--robot", "fanuc", "--timeout", "0.5"});
  EXPECT_EQ(result.exit_code, 4) << result.err;
  const auto jog = run_aprsim(daemon, {"crcl", "jog", "--robot", "fanuc", "--joint", "1", "--by",
                                       "60", "--speed", "5", "--timeout", "0.3"});
  EXPECT_EQ(jog.exit_code, 4) << jog.err;
  EXPECT_NE(jog.err.find("has been stopped"), std::string::npos) << jog.err;
}

}  // namespace
}  // namespace aprsim::test
