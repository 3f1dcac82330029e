// Who gets a connection, and who may do what with it.

#include <csignal>
#include <map>
#include <string>
#include <sys/resource.h>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/daemon_process.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/tcp_socket.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

const std::string kGetStatus =
    "<CRCLCommandInstance><CRCLCommand "
    "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:type=\"GetStatusType\">"
    "<CommandID>1</CommandID></CRCLCommand></CRCLCommandInstance>";

/// What each listener answers, by the beginning of its name; to nothing, those that speak first.
const std::map<std::string, std::string> kRequests{
    {"crcl", kGetStatus},
    {"modbus", std::string("\0\1\0\0\0\6\1\3\x80\0\0\1", 12)},
    {"vision", ""},
    {"grpc", ""},
    {"web", "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"}};

const std::string& request_of(const std::string& listener) {
  return kRequests.at(listener.substr(0, listener.find('.')));
}

/// Whether a client of this listener gets an answer to what it asks.
bool is_served(TcpSocket& client, const std::string& listener) {
  const std::string& request = request_of(listener);
  if (!request.empty() && !client.send(request)) return false;
  return !client.receive(TcpSocket::Clock::now() + 10s).empty();
}

void expect_service(const DaemonProcess& daemon) {
  for (const auto& [name, port] : daemon.ports()) {
    TcpSocket client(port);
    EXPECT_TRUE(is_served(client, name)) << name;
  }
}

TEST(Access, RunningOutOfDescriptorsEndsNobodysAccepting) {
  DaemonProcess daemon;
  rlimit before{};
  ASSERT_EQ(prlimit(daemon.pid(), RLIMIT_NOFILE, nullptr, &before), 0);
  const rlimit none{3, before.rlim_max};
  ASSERT_EQ(prlimit(daemon.pid(), RLIMIT_NOFILE, &none, nullptr), 0);
  std::map<std::string, TcpSocket> waiting;
  for (const auto& [name, port] : daemon.ports()) waiting.emplace(name, port);
  for (const auto& [name, port] : daemon.ports()) {
    std::string line = name + ": cannot accept: Too many open files";
    EXPECT_TRUE(eventually([&] { return daemon.log().find(line) != std::string::npos; }))
        << line << '\n'
        << daemon.log();
  }
  ASSERT_EQ(prlimit(daemon.pid(), RLIMIT_NOFILE, &before, nullptr), 0);
  for (auto& [name, client] : waiting) EXPECT_TRUE(is_served(client, name)) << name;
  expect_service(daemon);
  EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
}

TEST(Access, ClientsThatResetBeforeTheyAreAcceptedEndNobodysAccepting) {
  DaemonProcess daemon;
  kill(daemon.pid(), SIGSTOP);
  for (const auto& [name, port] : daemon.ports()) {
    for (int i = 0; i < 40; ++i) TcpSocket(port).reset();
  }
  kill(daemon.pid(), SIGCONT);
  expect_service(daemon);
  EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
}

/// With every place taken by clients that ask for nothing or never finish, newcomers are served:
/// from the same address, and from another.
TEST(Access, PlacesTakenByTheIdleAreGivenToNewcomers) {
  const DaemonProcess daemon({"--set", "crcl.max_connections=8", "--set",
                              "modbus.max_connections=8", "--set", "grpc.max_connections=8",
                              "--set", "web.max_connections=8"});
  for (const auto& [name, port] : daemon.ports()) {
    if (name.starts_with("vision")) continue;  // who only takes frames is not idle
    std::vector<TcpSocket> idle;
    for (int i = 0; i < 9; ++i) {
      idle.emplace_back(port);
      if (i % 2 == 1) (void)idle.back().send(request_of(name).substr(0, 3));
    }
    for (const char* from : {"", "127.0.0.2"}) {
      TcpSocket newcomer(port, 0, from);
      EXPECT_TRUE(is_served(newcomer, name)) << name << ' ' << from;
    }
  }
}

TEST(Access, VisionFeedsThatOneAddressHasTakenHaveAPlaceForAnother) {
  const DaemonProcess daemon({"--set", "vision.max_connections=4"});
  const std::uint16_t port = daemon.port("vision.fanuc");
  std::vector<TcpSocket> readers;
  for (int i = 0; i < 4; ++i) {
    readers.emplace_back(port);
    EXPECT_TRUE(is_served(readers.back(), "vision.fanuc"));
  }
  TcpSocket fifth(port);
  EXPECT_TRUE(fifth.ended());
  TcpSocket other(port, 0, "127.0.0.2");
  EXPECT_TRUE(is_served(other, "vision.fanuc"));
}

/// The ports file cannot be written while clients come and go.
TEST(Access, AnUnwritablePortsFileIsOneClearErrorAlsoWithClients) {
  const std::string daemon = std::string(APRSIM_BIN_DIR) + "/aprsimd";
  std::uint16_t port = 0;
  {
    const DaemonProcess first;
    port = first.port("crcl.fanuc");
  }
  std::jthread clients([port](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      try {
        TcpSocket client(port);
        (void)client.send(kGetStatus);
      } catch (const std::runtime_error&) {  // not listening
      }
    }
  });
  for (int i = 0; i < 10; ++i) {
    std::vector<std::string> argv{daemon, "--ports-file", "/nonexistent/ports.json", "--set",
                                  "crcl.ports.fanuc=" + std::to_string(port)};
    for (const char* other : {"crcl.ports.motoman", "vision.ports.fanuc", "vision.ports.motoman",
                              "modbus.port", "grpc.port", "web.port"}) {
      argv.insert(argv.end(), {"--set", std::string(other) + "=0"});
    }
    const auto result = run_process(argv);
    EXPECT_EQ(result.exit_code, 1) << result.err;
    EXPECT_NE(result.err.find("aprsimd: cannot write /nonexistent/ports.json"), std::string::npos)
        << result.err;
  }
}

}  // namespace
}  // namespace aprsim::test
