#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "crcl/documents.hpp"
#include "crcl/status.hpp"

namespace aprsim::test {

/// A CRCL server on a free loopback port for one client after another. It answers each GetStatus
/// with one status; a command reports Working to the first GetStatus behind it, and then whatever
/// the script says. Its joints are at 10, 20, ... 60 degrees, its tool at (300, 0, 400).
class ScriptedRobot {
 public:
  /// The outcome of a command: kDone, or kError with the description.
  using Script = std::function<crcl::CommandStatus(const crcl::Command&)>;
  /// `last_id` is what the first status shows, as left by an earlier client.
  explicit ScriptedRobot(Script script, std::int64_t last_id = -1);
  ~ScriptedRobot();

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// Commands received so far, GetStatus not counted.
  [[nodiscard]] std::vector<crcl::Command> commands() const;

 private:
  void serve();
  /// The next client's socket, for the destructor to end; false once that has begun.
  [[nodiscard]] bool begin(int fd);
  void end(int fd);
  void talk(int fd);
  [[nodiscard]] std::string answer();

  const Script script_;
  int listen_fd_ = -1;
  std::uint16_t port_ = 0;
  mutable std::mutex mutex_;  // of all that follows
  std::vector<crcl::Command> commands_;
  crcl::CommandStatus now_, next_;
  int client_fd_ = -1;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace aprsim::test
