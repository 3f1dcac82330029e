#include "server/operations/service_manager.hpp"

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/support/temporary_directory.hpp"

namespace aprsim::server {
namespace {

using namespace std::chrono_literals;

/// The socket that systemd would listen at.
class Systemd {
 public:
  explicit Systemd(const std::string& path) : socket_(::socket(AF_UNIX, SOCK_DGRAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path.data(), path.size());
    if (path[0] == '@') address.sun_path[0] = '\0';
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), size), 0);
  }
  ~Systemd() { ::close(socket_); }
  Systemd(const Systemd&) = delete;
  Systemd& operator=(const Systemd&) = delete;

  /// The next message; "" = there is none.
  [[nodiscard]] std::string next() const {
    std::array<char, 512> text{};
    const ssize_t size = ::recv(socket_, text.data(), text.size(), MSG_DONTWAIT);
    return size < 0 ? "" : std::string(text.data(), static_cast<std::size_t>(size));
  }

 private:
  int socket_;
};

class ServiceManagerTest : public testing::Test {
 protected:
  ~ServiceManagerTest() override {
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) ::unsetenv(name);
  }
  static void set(const char* name, const std::string& value) { ::setenv(name, value.c_str(), 1); }

  test::TemporaryDirectory directory_;
  std::string path_ = directory_.path() + "/notify";
};

TEST_F(ServiceManagerTest, SaysNothingWhenNobodyListens) {
  ServiceManager nobody;
  EXPECT_FALSE(nobody.period());
  nobody.ready();
  set("NOTIFY_SOCKET", directory_.path() + "/none");
  ServiceManager none;
  none.ready();
  set("NOTIFY_SOCKET", std::string(300, 'x'));
  ServiceManager too_long;
  too_long.ready();
}

TEST_F(ServiceManagerTest, TellsTheProcesssLife) {
  for (const std::string& path : {path_, "@aprsim-test-" + std::to_string(::getpid())}) {
    const Systemd systemd(path);
    set("NOTIFY_SOCKET", path);
    ServiceManager manager;
    manager.ready();
    EXPECT_EQ(systemd.next(), "READY=1");
    manager.working(true, "");
    EXPECT_EQ(systemd.next(), "") << "no watchdog is asked for";
    manager.working(true, "the pace is 0.11\ninstead of 1");
    manager.working(true, "the pace is 0.11\ninstead of 1");
    EXPECT_EQ(systemd.next(), "STATUS=not serving: the pace is 0.11 instead of 1");
    EXPECT_EQ(systemd.next(), "");
    manager.working(true, "");
    EXPECT_EQ(systemd.next(), "STATUS=serving");
    manager.stopping();
    EXPECT_EQ(systemd.next(), "STOPPING=1");
  }
}

TEST_F(ServiceManagerTest, KeepsTheWatchdogQuietOnlyWhileThereIsProgress) {
  const Systemd systemd(path_);
  set("NOTIFY_SOCKET", path_);
  set("WATCHDOG_USEC", "500000");
  set("WATCHDOG_PID", std::to_string(::getpid()));
  ServiceManager manager;
  EXPECT_EQ(manager.period(), 250ms);
  manager.working(true, "");
  EXPECT_EQ(systemd.next(), "WATCHDOG=1");
  manager.working(false, "");
  EXPECT_EQ(systemd.next(), "");
  set("WATCHDOG_PID", "1");
  ServiceManager of_another;
  of_another.working(true, "");
  EXPECT_EQ(systemd.next(), "") << "the watchdog is for another process";
}

}  // namespace
}  // namespace aprsim::server
