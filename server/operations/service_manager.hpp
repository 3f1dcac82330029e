#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace aprsim::server {

/// Tells systemd, when it has started this process as a unit of Type=notify, what becomes of it:
/// datagrams to the socket that NOTIFY_SOCKET names, see sd_notify(3). Else nothing happens.
/// A message that cannot be sent is left out. Thread: one.
class ServiceManager {
 public:
  /// Reads the variables NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  void ready() { send("READY=1"); }
  void stopping() { send("STOPPING=1"); }
  /// The process does what it is there for, and what keeps it from doing it well; empty = nothing.
  /// Unchanged status is not sent again.
  void working(bool progress, const std::string& problem);

  /// How often working() has to be called; absent = nobody asks.
  [[nodiscard]] std::optional<std::chrono::milliseconds> period() const { return period_; }

 private:
  void send(const std::string& message) const;

  std::string path_;
  int socket_ = -1;
  bool watched_ = false;
  std::string problem_;
  std::optional<std::chrono::milliseconds> period_;
};

}  // namespace aprsim::server
