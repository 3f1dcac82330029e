#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace aprsim::server {

/// Reports the state of the process to systemd if it runs as a unit of Type=notify: datagrams to
/// the socket in NOTIFY_SOCKET, see sd_notify(3). Otherwise it does nothing. Messages that cannot
/// be sent are dropped. Thread: one.
class ServiceManager {
 public:
  /// Reads the variables NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  void ready() { send("READY=1"); }
  void stopping() { send("STOPPING=1"); }
  /// Reports whether the simulation makes progress, and the problem that it has; empty = none. An
  /// unchanged status is not sent again.
  void working(bool progress, const std::string& problem);

  /// Period in which working() has to be called; absent = never.
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
