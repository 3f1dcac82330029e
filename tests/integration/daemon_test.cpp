// The real daemon as its user meets it: command line, ports, signals.

#include <array>
#include <csignal>
#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <poll.h>
#include <stdexcept>
#include <string>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <gtest/gtest.h>

#include "tests/support/cell_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/tcp_socket.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

/// Docker kills a container so long after it has asked it to stop. A daemon that waited for a
/// client would take longer on any machine.
constexpr auto kStopDeadline = kPatience * 10s;

const std::string kDaemon = std::string(APRSIM_BIN_DIR) + "/aprsimd";

std::size_t lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(Daemon, ServesOnEveryPortOfItsPortsFile) {
  DaemonProcess daemon;
  for (const auto* name : {"crcl.fanuc", "crcl.motoman", "modbus", "grpc", "web"}) {
    EXPECT_NO_THROW(TcpSocket{daemon.port(name)}) << name;
  }
  CellClient client(daemon.port("grpc"));
  EXPECT_EQ(client.cell().scene(), "aprs");
  client.wait_for([](const auto& snapshot) { return snapshot.step() > 100; }, "time to pass");
}

TEST(Daemon, SigtermEndsCleanlyAlsoWithClients) {
  DaemonProcess daemon;
  const TcpSocket crcl(daemon.port("crcl.fanuc")), modbus(daemon.port("modbus")),
      web(daemon.port("web"));
  CellClient client(daemon.port("grpc"));
  grpc::ClientContext context;
  auto stream = client.telemetry->StreamSnapshots(&context, {});
  v1::StreamSnapshotsResponse first;
  ASSERT_TRUE(stream->Read(&first));
  const auto result = daemon.stop(SIGTERM);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_LT(result.took, kStopDeadline);
}

/// Asks and never reads, until nothing more is taken.
class StalledClient {
 public:
  StalledClient(std::uint16_t port, const std::string& request) : socket_(port, 4096) {
    // Whole requests only matter until the server stops reading.
    auto last = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - last < 150ms) {
      const auto sent = socket_.send_some(request);
      if (!sent) throw std::runtime_error("closed");
      if (*sent > 0) {
        last = std::chrono::steady_clock::now();
      } else {
        std::this_thread::yield();
      }
    }
  }

 private:
  TcpSocket socket_;
};

TEST(Daemon, SigtermEndsThoughNobodyTakesItsReplies) {
  DaemonProcess daemon;
  std::string statuses;
  for (int i = 0; i < 100; ++i) {
    statuses +=
        "<CRCLCommandInstance><CRCLCommand "
        "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:type=\"GetStatusType\">"
        "<CommandID>1</CommandID></CRCLCommand></CRCLCommandInstance>";
  }
  std::string reads;
  for (int i = 0; i < 500; ++i) reads += std::string("\0\1\0\0\0\6\1\3\x80\0\0\x7d", 12);
  const StalledClient fanuc(daemon.port("crcl.fanuc"), statuses);
  const StalledClient motoman(daemon.port("crcl.motoman"), statuses);
  const StalledClient modbus(daemon.port("modbus"), reads);
  CellClient client(daemon.port("grpc"));
  grpc::ClientContext context;
  v1::StreamSnapshotsRequest all;
  all.set_rate_hz(1000);
  auto stream = client.telemetry->StreamSnapshots(&context, all);  // never read
  client.wait_for([](const auto& snapshot) { return snapshot.step() > 500; }, "time to pass");
  const auto result = daemon.stop(SIGTERM);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_LT(result.took, kStopDeadline);
}

/// A pipe of one page, as a log.
class LogPipe {
 public:
  LogPipe() {
    if (pipe2(ends_.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    if (fcntl(ends_[1], F_SETPIPE_SZ, 4096) < 0) throw std::runtime_error("no small pipe");
  }
  ~LogPipe() {
    for (const int end : ends_) ::close(end);
  }
  LogPipe(const LogPipe&) = delete;
  LogPipe& operator=(const LogPipe&) = delete;
  [[nodiscard]] int writing_end() const { return ends_[1]; }
  /// Reads until the log has said this.
  bool reads(const std::string& text) {
    const auto deadline = std::chrono::steady_clock::now() + 10s;
    std::string all;
    while (all.find(text) == std::string::npos && std::chrono::steady_clock::now() < deadline) {
      std::array<char, 65536> some{};
      pollfd wait{ends_[0], POLLIN, 0};
      if (poll(&wait, 1, 100) <= 0) continue;
      const ssize_t size = ::read(ends_[0], some.data(), some.size());
      if (size > 0) all.append(some.data(), static_cast<std::size_t>(size));
    }
    return all.find(text) != std::string::npos;
  }

 private:
  std::array<int, 2> ends_{};
};

/// Makes the daemon log some 10 000 lines, more than it keeps.
void make_it_log(const DaemonProcess& daemon) {
  TcpSocket socket(daemon.port("crcl.fanuc"));
  const std::string head =
      "<CRCLCommandInstance><CRCLCommand "
      "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:type=\"";
  const std::string end = "Type\"><CommandID>1</CommandID></CRCLCommand></CRCLCommandInstance>";
  std::string many;
  for (int i = 0; i < 100; ++i) many += head + "InitCanon" + end;
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(socket.send(many));
  ASSERT_TRUE(socket.send(head + "GetStatus" + end));
  ASSERT_FALSE(socket.receive(TcpSocket::Clock::now() + 20s).empty());
}

TEST(Daemon, SigtermEndsThoughNobodyReadsItsLog) {
  LogPipe log;
  DaemonProcess daemon({"--set", "log_level=debug"}, log.writing_end());
  make_it_log(daemon);
  const auto result = daemon.stop(SIGTERM);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_LT(result.took, kStopDeadline);
}

TEST(Daemon, ALogThatFlowsAgainTellsHowManyLinesWereLost) {
  LogPipe log;
  DaemonProcess daemon({"--set", "log_level=debug"}, log.writing_end());
  make_it_log(daemon);
  EXPECT_TRUE(log.reads(" log lines lost: their reader was too slow"));
}

TEST(Daemon, APortInUseIsOneClearLineAndExitCodeOne) {
  boost::asio::io_context io;
  boost::asio::ip::tcp::acceptor taken(io, {boost::asio::ip::address_v4::loopback(), 0});
  const std::string port = std::to_string(taken.local_endpoint().port());
  for (const auto* key : {"modbus.port=", "grpc.port=", "crcl.ports.fanuc=",
                          "vision.ports.motoman=", "cameras.port=", "web.port="}) {
    std::vector<std::string> argv = {kDaemon, "--set", "log_level=error"};
    for (const auto* other :
         {"modbus.port=", "grpc.port=", "crcl.ports.fanuc=", "crcl.ports.motoman=",
          "vision.ports.fanuc=", "vision.ports.motoman=", "cameras.port=", "web.port="}) {
      argv.insert(argv.end(),
                  {"--set", std::string(other) + (key == std::string(other) ? port : "0")});
    }
    const auto result = run_process(argv);
    EXPECT_EQ(result.exit_code, 1) << key;
    EXPECT_EQ(lines(result.err), 1U) << result.err;
    EXPECT_NE(result.err.find(port), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("in use"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find(std::string("--set ") + key + "PORT"), std::string::npos)
        << result.err;
  }
}

TEST(Daemon, PrintConfigPrintsWhatItReads) {
  const auto printed = run_process({kDaemon, "--set", "modbus.port=1234", "--speed", "stepped",
                                    "--seed", "9", "--print-config"});
  ASSERT_EQ(printed.exit_code, 0) << printed.err;
  EXPECT_NE(printed.out.find("port: 1234"), std::string::npos);
  const std::string file = testing::TempDir() + "aprsim-config.yaml";
  std::ofstream(file) << printed.out;
  const auto again = run_process({kDaemon, "--config", file, "--print-config"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(again.out, printed.out);
}

TEST(Daemon, WrongConfigurationNamesKeyValueAndPlace) {
  const std::string file = testing::TempDir() + "aprsim-wrong.yaml";
  std::ofstream(file) << "modbus:\n  prot: 1\n";
  const auto unknown = run_process({kDaemon, "--config", file});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find(file + ":2:"), std::string::npos) << unknown.err;
  EXPECT_NE(unknown.err.find("prot"), std::string::npos) << unknown.err;
  const auto range = run_process({kDaemon, "--set", "modbus.port=70000", "--check"});
  EXPECT_EQ(range.exit_code, 2);
  EXPECT_NE(range.err.find("70000"), std::string::npos) << range.err;
  const auto speed = run_process({kDaemon, "--speed", "fast", "--check"});
  EXPECT_EQ(speed.exit_code, 2);
  EXPECT_NE(speed.err.find("fast"), std::string::npos) << speed.err;
  const auto scene = run_process({kDaemon, "--scene", "nowhere", "--check"});
  EXPECT_EQ(scene.exit_code, 1);
  EXPECT_NE(scene.err.find("nowhere"), std::string::npos) << scene.err;
}

TEST(Daemon, ChecksEveryShippedScene) {
  for (const auto* scene :
       {"aprs", "aprs_2024", "aprs_2025", "aprs_lab", "fanuc_only", "motoman_only", "sorting",
        "table1", "empty_belt", "taskboard", "taskboard_keys", "arms", "ariac", "two_arms"}) {
    const auto result = run_process({kDaemon, "--scene", scene, "--check"});
    EXPECT_EQ(result.exit_code, 0) << scene << ": " << result.err;
  }
}

/// Processes that a process has started and that still run.
std::vector<pid_t> children_of(pid_t pid) {
  std::vector<pid_t> out;
  const std::filesystem::path tasks = "/proc/" + std::to_string(pid) + "/task";
  for (const auto& task : std::filesystem::directory_iterator(tasks)) {
    std::ifstream children(task.path() / "children");
    for (pid_t child = 0; children >> child;) out.push_back(child);
  }
  return out;
}

TEST(Daemon, TheDemoMovesARobotAndEndsWithTheDaemon) {
  DaemonProcess daemon({"--demo"});
  CellClient client(daemon.port("grpc"));
  client.wait_for(
      [](const auto& snapshot) {
        return snapshot.robots(0).moving() || snapshot.robots(1).moving();
      },
      "a robot to move", 60s);
  const auto children = children_of(daemon.pid());
  ASSERT_EQ(children.size(), 1U) << daemon.log();
  const auto result = daemon.stop(SIGTERM);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_LT(result.took, kStopDeadline);
  EXPECT_EQ(kill(children[0], 0), -1) << "it has been waited for";
}

TEST(Daemon, ADemoThatCannotBeIsOneClearLine) {
  const auto unknown = run_process(
      {kDaemon, "--demo", "--scene", "table1", "--any-port", "--set", "log_level=error"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_EQ(lines(unknown.err), 1U) << unknown.err;
  EXPECT_NE(unknown.err.find("--demo: the kitting controller does not know this cell"),
            std::string::npos)
      << unknown.err;
  const auto paced = run_process({kDaemon, "--demo", "--time", "virtual", "--any-port"});
  EXPECT_EQ(paced.exit_code, 2);
  EXPECT_NE(paced.err.find("--demo: not possible in virtual time"), std::string::npos) << paced.err;
}

TEST(Daemon, SteppedTimeMovesOnlyWhenStepped) {
  DaemonProcess daemon({"--speed", "stepped", "--scene", "empty_belt"});
  CellClient client(daemon.port("grpc"));
  EXPECT_EQ(client.snapshot().step(), 0U);
  EXPECT_EQ(client.step(250).receipt().step(), 250U);
  EXPECT_EQ(client.snapshot().step(), 250U);
  v1::ResetResponse reset;
  grpc::ClientContext context;
  CellClient::require(client.control->Reset(&context, {}, &reset));
  EXPECT_EQ(client.snapshot().step(), 0U);
  EXPECT_EQ(client.snapshot().epoch(), 1U);
}

}  // namespace
}  // namespace aprsim::test
