// Connection limits and permissions of every listener.

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <poll.h>
#include <string>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/tcp_socket.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

const std::string kGetStatus =
    "<CRCLCommandInstance><CRCLCommand "
    "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:type=\"GetStatusType\">"
    "<CommandID>1</CommandID></CRCLCommand></CRCLCommandInstance>";

/// A request that each listener answers, by the start of its name; empty where the server sends
/// first.
const std::map<std::string, std::string> kRequests{
    {"crcl", kGetStatus}, {"modbus", std::string("\0\1\0\0\0\6\1\3\x80\0\0\1", 12)},
    {"vision", ""},       {"camera", "GET / HTTP/1.1\r\n\r\n"},
    {"grpc", ""},         {"web", "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"}};

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

/// New clients are served, from the same address and from another, when idle or incomplete clients
/// hold every connection.
TEST(Access, PlacesTakenByTheIdleAreGivenToNewcomers) {
  const DaemonProcess daemon({"--set", "crcl.max_connections=8", "--set",
                              "modbus.max_connections=8", "--set", "grpc.max_connections=8",
                              "--set", "web.max_connections=8", "--set",
                              "cameras.max_connections=8"});
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

std::string command_line_of(pid_t pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/cmdline");
  return {std::istreambuf_iterator<char>(in), {}};
}

const std::string kAprsimd = std::string(APRSIM_BIN_DIR) + "/aprsimd";

TEST(Access, TheTokenIsReadFromAFileAndShownNowhere) {
  const TemporaryDirectory directory;
  directory.write("token", "open sesame\n");
  directory.write("config.yaml", "web:\n  token: open sesame\n");
  const std::string file = directory.path() + "/token", config = directory.path() + "/config.yaml";
  for (const auto& arguments : {std::vector<std::string>{"--token-file", file},
                                {"--set", "web.token_file=" + file, "--set", "web.control=false"},
                                {"--config", config}}) {
    DaemonProcess daemon(arguments);
    CellClient client(daemon.port("grpc"));
    EXPECT_EQ(client.cell().scene(), "aprs");
    const auto pause = [&](const std::string& token) {
      grpc::ClientContext context;
      if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
      v1::PauseResponse response;
      return client.control->Pause(&context, {}, &response).error_code();
    };
    EXPECT_EQ(pause(""), grpc::StatusCode::UNAUTHENTICATED);
    EXPECT_EQ(pause("close sesame"), grpc::StatusCode::UNAUTHENTICATED);
    EXPECT_EQ(pause("open sesame"), grpc::StatusCode::OK);
    EXPECT_EQ(command_line_of(daemon.pid()).find("sesame"), std::string::npos);
    const auto end = daemon.stop(SIGTERM);
    EXPECT_EQ(end.err.find("sesame"), std::string::npos) << end.err;
    auto argv = arguments;
    for (const char* print : {"--print-config", "--list-keys"}) {
      argv.insert(argv.begin(), {kAprsimd, print});
      const auto printed = run_process(argv);
      EXPECT_EQ(printed.exit_code, 0) << printed.err;
      EXPECT_EQ((printed.out + printed.err).find("sesame"), std::string::npos) << printed.out;
      argv = arguments;
    }
  }
}

TEST(Access, ATokenOnTheCommandLineIsRefused) {
  for (const char* argument : {"web.token=open sesame", "web={token: open sesame}"}) {
    const auto result = run_process({kAprsimd, "--set", argument, "--check"});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("not allowed on the command line"), std::string::npos) << result.err;
    EXPECT_EQ(result.err.find("sesame"), std::string::npos) << result.err;
  }
  const auto missing = run_process({kAprsimd, "--token-file", "/nonexistent", "--check"});
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_NE(missing.err.find("/nonexistent: No such file"), std::string::npos) << missing.err;
}

TEST(Access, EachListenerThatIsOpenToOthersSaysWhoMayCommand) {
  std::vector<std::string> open;
  for (const char* key : {"crcl", "modbus", "vision", "cameras", "grpc", "web"}) {
    open.insert(open.end(), {"--set", std::string(key) + ".address=0.0.0.0"});
  }
  DaemonProcess daemon(open);
  const std::string log = daemon.stop(SIGTERM).err;
  for (const auto& [name, port] : daemon.ports()) {
    EXPECT_NE(log.find(name + " is open to other machines at "), std::string::npos) << log;
  }
  EXPECT_EQ(DaemonProcess().log().find("open to other machines"), std::string::npos);
}

TEST(Access, TheVersionSaysWhichAssertsAreKept) {
  const auto version = run_process({kAprsimd, "--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_NE(version.out.find("asserts kept: aprsim, Eigen, ODE\n"), std::string::npos)
      << version.out;
}

/// As systemd would see it.
TEST(Access, TheServiceManagerIsToldTheDaemonsLife) {
  const TemporaryDirectory directory;
  const std::string path = directory.path() + "/notify";
  const int socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  ::setenv("WATCHDOG_USEC", "100000", 1);
  DaemonProcess daemon({"--scene", "empty_belt"});
  ::unsetenv("NOTIFY_SOCKET");
  ::unsetenv("WATCHDOG_USEC");
  const auto next = [socket] {
    std::array<char, 512> text{};
    pollfd waiting{socket, POLLIN, 0};
    if (::poll(&waiting, 1, 10'000) != 1) return std::string("nothing");
    const ssize_t size = ::recv(socket, text.data(), text.size(), 0);
    return std::string(text.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  };
  EXPECT_EQ(next(), "READY=1");
  for (int i = 0; i < 5; ++i) EXPECT_EQ(next(), "WATCHDOG=1");
  EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  std::string last;
  while ((last = next()) == "WATCHDOG=1") {
  }
  EXPECT_EQ(last, "STOPPING=1");
  ::close(socket);
}

/// The ports file cannot be written while clients come and go.
TEST(Access, AnUnwritablePortsFileIsOneClearErrorAlsoWithClients) {
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
    std::vector<std::string> argv{kAprsimd, "--ports-file", "/nonexistent/ports.json", "--set",
                                  "crcl.ports.fanuc=" + std::to_string(port)};
    for (const char* other : {"crcl.ports.motoman", "vision.ports.fanuc", "vision.ports.motoman",
                              "modbus.port", "cameras.port", "grpc.port", "web.port"}) {
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
