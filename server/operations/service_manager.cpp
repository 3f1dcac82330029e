#include "server/operations/service_manager.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace aprsim::server {
namespace {

constexpr std::chrono::milliseconds kStatusPeriod{1000};

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::optional<std::int64_t> whole(const std::string& text) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value <= 0) return std::nullopt;
  return value;
}

}  // namespace

ServiceManager::ServiceManager() : path_(variable("NOTIFY_SOCKET")) {
  if (path_.empty()) return;
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  period_ = kStatusPeriod;
  const auto watchdog_us = whole(variable("WATCHDOG_USEC"));
  const auto pid = whole(variable("WATCHDOG_PID"));
  watched_ = watchdog_us && (!pid || *pid == ::getpid());
  // Half the time that systemd allows.
  if (watched_) {
    period_ = std::clamp(std::chrono::milliseconds(*watchdog_us / 2000),
                         std::chrono::milliseconds(1), kStatusPeriod);
  }
}

ServiceManager::~ServiceManager() {
  if (socket_ >= 0) ::close(socket_);
}

void ServiceManager::working(bool progress, const std::string& problem) {
  if (watched_ && progress) send("WATCHDOG=1");
  if (problem == problem_) return;
  problem_ = problem;
  std::string line = problem.empty() ? "serving" : "not serving: " + problem;
  std::ranges::replace(line, '\n', ' ');
  send("STATUS=" + line);
}

void ServiceManager::send(const std::string& message) const {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (socket_ < 0 || path_.size() >= sizeof address.sun_path) return;
  std::memcpy(address.sun_path, path_.data(), path_.size());
  // A leading "@" means the abstract namespace.
  if (path_[0] == '@') address.sun_path[0] = '\0';
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path_.size());
  (void)::sendto(socket_, message.data(), message.size(), MSG_NOSIGNAL,
                 reinterpret_cast<const sockaddr*>(&address), size);
}

}  // namespace aprsim::server
