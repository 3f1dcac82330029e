// `aprsim conform`: our servers keep every rule, and servers that are wrong are found wrong.

#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "clients/aprsim/conform/check.hpp"
#include "tests/integration/cli/cli_commands.hpp"
#include "tests/support/eventually.hpp"
#include "world/base/process/child_process.hpp"

namespace aprsim::test {
namespace {

/// Verdict and observation of each clause.
std::map<std::string, nlohmann::json> findings(const ProcessResult& result) {
  std::map<std::string, nlohmann::json> all;
  std::istringstream lines(result.out);
  for (std::string line; std::getline(lines, line);) {
    const auto object = nlohmann::json::parse(line);
    if (object.contains("clause")) all[object["clause"]] = object;
  }
  return all;
}

ProcessResult conform(const std::vector<std::string>& arguments) {
  std::vector<std::string> argv{std::string(APRSIM_BIN_DIR) + "/aprsim", "conform"};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  argv.push_back("--json");
  return run_process(argv, std::chrono::seconds(180));
}

std::string address(std::uint16_t port) { return "127.0.0.1:" + std::to_string(port); }

void expect_all_kept(const ProcessResult& result, std::size_t rules) {
  for (const auto& [clause, finding] : findings(result)) {
    EXPECT_EQ(finding["verdict"], "pass") << finding.dump();
  }
  EXPECT_EQ(findings(result).size(), rules) << result.err;
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

TEST(Conform, OurCrclServerKeepsEveryRule) {
  const DaemonProcess daemon({"--scene", "fanuc_only"});
  expect_all_kept(conform({"crcl", address(daemon.port("crcl.fanuc")), "--allow-motion"}),
                  client::conform::crcl_checks().size());
}

TEST(Conform, EveryArmsServerKeepsEveryRule) {
  const DaemonProcess daemon({"--scene", "arms"});
  for (const char* robot : {"ur5e", "irb120", "panda", "scara"}) {
    SCOPED_TRACE(robot);
    const std::uint16_t port = daemon.port("crcl." + std::string(robot));
    expect_all_kept(conform({"crcl", address(port), "--allow-motion"}),
                    client::conform::crcl_checks().size());
  }
}

TEST(Conform, ServerWithSchemaValidationKeepsEveryRule) {
  const DaemonProcess daemon({"--scene", "fanuc_only", "--set", "crcl.validation=strict"});
  const auto found = findings(conform({"crcl", address(daemon.port("crcl.fanuc"))}));
  for (const auto& check : client::conform::crcl_checks()) {
    EXPECT_EQ(found.at(check.clause)["verdict"], check.moves ? "not checked" : "pass")
        << found.at(check.clause).dump();
  }
  EXPECT_TRUE(found.at("V10")["seen"].get<std::string>().starts_with("strict"));
}

TEST(Conform, OurModbusServerKeepsEveryRule) {
  const DaemonProcess daemon({"--scene", "empty_belt"});
  expect_all_kept(conform({"modbus", address(daemon.port("modbus")), "--allow-motion"}),
                  client::conform::modbus_checks().size());
}

TEST(Conform, NothingMovesUnlessItIsAllowed) {
  const DaemonProcess daemon({"--scene", "empty_belt"});
  const auto found = findings(conform({"modbus", address(daemon.port("modbus"))}));
  for (const auto& check : client::conform::modbus_checks()) {
    EXPECT_EQ(found.at(check.clause)["verdict"], check.moves ? "not checked" : "pass")
        << check.clause;
  }
}

/// A server of tests/integration/cli/wrong_servers while it lives.
class WrongServer {
 public:
  explicit WrongServer(const std::string& name)
      : process_(*process::ChildProcess::start(
            {"python3",
             std::string(APRSIM_SOURCE_DIR) + "/tests/integration/cli/wrong_servers/" + name},
            {}, "/dev/null", process::ChildProcess::Pipes::kInputAndOutput)) {
    EXPECT_TRUE(eventually(
        [this] {
          for (const std::string& line : process_.lines()) port_ = line;
          return !port_.empty();
        },
        std::chrono::seconds(30)));
  }
  ~WrongServer() { process_.stop(std::chrono::seconds(5)); }

  [[nodiscard]] std::string address() const { return "127.0.0.1:" + port_; }

 private:
  process::ChildProcess process_;
  std::string port_;
};

void expect_not_kept(const ProcessResult& result, const std::set<std::string>& clauses) {
  EXPECT_EQ(result.exit_code, 1) << result.err;
  const auto found = findings(result);
  for (const std::string& clause : clauses) {
    EXPECT_EQ(found.at(clause)["verdict"], "fail") << found.at(clause).dump();
    EXPECT_NE(found.at(clause)["seen"], "") << clause;
  }
}

TEST(Conform, AWrongCrclServerIsFoundWrong) {
  const WrongServer server("wrong_crcl_server.py");
  expect_not_kept(conform({"crcl", server.address()}),
                  {"F10", "F11", "F12", "S1", "S2", "S3", "S4", "S6", "S7", "C3", "C9", "C10", "U1",
                   "U2", "V1", "V2", "V5", "V9", "G1"});
}

TEST(Conform, AWrongModbusServerIsFoundWrong) {
  const WrongServer server("wrong_modbus_server.py");
  // Rules of functions: none read, too many read, below the range, unknown ones; of the map: run.
  expect_not_kept(conform({"modbus", server.address()}),
                  {"T2", "T3", "T5", "T6", "FC5", "FC6", "FC9", "R2"});
}

TEST(Conform, MissingServerIsNoVerdict) {
  EXPECT_EQ(conform({"crcl", "127.0.0.1:1"}).exit_code, 3);
  EXPECT_EQ(conform({"modbus", "127.0.0.1"}).exit_code, 2);
  EXPECT_EQ(conform({"crcl"}).exit_code, 2);
}

TEST(Conform, PageOfRulesMatchesTheChecks) {
  const ProcessResult page =
      run_process({std::string(APRSIM_BIN_DIR) + "/aprsim", "conform", "clauses"});
  std::ifstream file(std::string(APRSIM_SOURCE_DIR) + "/protocols/CLAUSES.md");
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_TRUE(text.str().ends_with(page.out)) << "renew it: aprsim conform clauses > its tables";
}

}  // namespace
}  // namespace aprsim::test
