// Incidents over gRPC, with the client and over HTTP: files that are run again elsewhere.

#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/raw_web_client.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::test {
namespace {

const std::string kBin = APRSIM_BIN_DIR;

ProcessResult incident(const DaemonProcess& daemon, const std::string& last,
                       const std::string& file) {
  return run_process({kBin + "/aprsim", "--ports-file", daemon.ports_file(), "incident", "--last",
                      last, "--file", file, "--json"});
}

/// Moves a robot and passes so much time.
void pass_with_robot(const DaemonProcess& daemon, std::uint64_t steps) {
  CellClient cell(daemon.port("grpc"));
  CrclTextClient fanuc(daemon.port("crcl.fanuc"));
  fanuc.send("InitCanonType");
  fanuc.status();
  cell.step(steps);
}

class Incident : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const {
    return directory_.path() + "/" + name;
  }
  /// The report of a replay that finds no difference.
  static std::string replayed(const std::string& file) {
    const auto again = run_process({kBin + "/aprsimd", "--replay", file}, std::chrono::minutes(4));
    EXPECT_EQ(again.exit_code, 0) << again.out << again.err;
    EXPECT_NE(again.out.find("all states are the same"), std::string::npos) << again.out;
    EXPECT_EQ(again.out.find("ends early"), std::string::npos) << again.out;
    return again.out;
  }

  TemporaryDirectory directory_;
};

TEST_F(Incident, TheDaemonsNameForItReplacesNoFile) {
  DaemonProcess daemon({"--speed", "stepped"});
  pass_with_robot(daemon, 100);
  const std::string command =
      fmt::format("cd '{}' && '{}/aprsim' --ports-file '{}' incident --last 1s", directory_.path(),
                  kBin, daemon.ports_file());
  const auto first = run_process({"/bin/sh", "-c", command});
  EXPECT_EQ(first.exit_code, 0) << first.err;
  const auto second = run_process({"/bin/sh", "-c", command});
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_NE(second.err.find("exists already; name another file by --file"), std::string::npos)
      << second.err;
}

TEST_F(Incident, IsRunAgainWhenItsDaemonIsGone) {
  {
    DaemonProcess daemon({"--speed", "stepped"});
    pass_with_robot(daemon, 25'000);
    const auto short_one = incident(daemon, "3s", path("short"));
    ASSERT_EQ(short_one.exit_code, 0) << short_one.err;
    const auto told = nlohmann::json::parse(short_one.out);
    EXPECT_EQ(told["bytes"], std::filesystem::file_size(path("short")));
    EXPECT_EQ(incident(daemon, "10min", path("long")).exit_code, 0);
    // It is complete, and not the journal of a daemon that was killed.
    const auto same =
        run_process({kBin + "/aprsim", "trace", "diff", path("short"), path("short"), "--json"});
    EXPECT_EQ(same.exit_code, 0) << same.err;
    EXPECT_EQ(nlohmann::json::parse(same.out)["notes"], nlohmann::json::array()) << same.out;
    RawWebClient web(daemon.port("web"));
    const std::string answer = web.request("GET /incident?last=3 HTTP/1.1");
    EXPECT_NE(answer.find("200 OK"), std::string::npos);
    EXPECT_NE(answer.find("attachment; filename=\"aprsim-"), std::string::npos);
    std::ofstream(path("web"), std::ios::binary) << answer.substr(answer.find("\r\n\r\n") + 4);
    daemon.stop(SIGKILL);
  }
  EXPECT_NE(replayed(path("short")).find(" 5000 steps"), std::string::npos);
  EXPECT_NE(replayed(path("web")).find(" 5000 steps"), std::string::npos);
  EXPECT_NE(replayed(path("long")).find(" 25000 steps"), std::string::npos);
}

TEST_F(Incident, IsTakenBesideAJournalOnDisk) {
  DaemonProcess daemon({"--speed", "stepped", "--journal", path("run.journal"), "--no-web"});
  pass_with_robot(daemon, 12'000);
  EXPECT_EQ(incident(daemon, "1s", path("incident")).exit_code, 0);
  EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  EXPECT_NE(replayed(path("incident")).find(" 2000 steps"), std::string::npos);
  // Both are of one run: their directory stands for neither.
  std::filesystem::rename(path("incident"), path("incident.journal"));
  const auto both = run_process({kBin + "/aprsimd", "--replay", path("")});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_NE(both.err.find("two files of one part"), std::string::npos) << both.err;
  EXPECT_NE(replayed(path("run.journal")).find(" 12000 steps"), std::string::npos);
}

TEST_F(Incident, RefusesInvalidRequests) {
  DaemonProcess daemon({"--set", "journal.memory_mb=0"});
  const auto none = incident(daemon, "60s", path("none"));
  EXPECT_NE(none.exit_code, 0);
  EXPECT_NE(none.err.find("journal.memory_mb"), std::string::npos) << none.err;
  EXPECT_FALSE(std::filesystem::exists(path("none")));
  for (const char* last : {"0", "-3s", "5h", "s", "100000s"}) {
    const auto wrong = incident(daemon, last, path("none"));
    EXPECT_EQ(wrong.exit_code, 2) << last;
    EXPECT_NE(wrong.err.find("--last"), std::string::npos) << wrong.err;
  }
  RawWebClient web(daemon.port("web"));
  EXPECT_NE(web.request("GET /incident HTTP/1.1").find(" 404 "), std::string::npos);
  for (const char* query : {"?last=0", "?last=x", "?last=", "?from=3", "?last=1e9"}) {
    EXPECT_NE(web.request("GET /incident" + std::string(query) + " HTTP/1.1").find(" 400 "),
              std::string::npos)
        << query;
  }
}

}  // namespace
}  // namespace aprsim::test
