#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "clients/wires/endpoints.hpp"
#include "clients/wires/outcome.hpp"
#include "clients/wires/tcp_socket.hpp"
#include "crcl/documents.hpp"
#include "crcl/framer.hpp"
#include "crcl/status.hpp"

namespace aprsim::client {

/// One CRCL connection to a robot, used as the reference clients use it: a command is sent and gets
/// no answer; its progress is read by asking for the status until that reports its id as done.
class CrclSession {
 public:
  using Seconds = std::chrono::duration<double>;

  /// Connects and reads the status once, to number commands on from the robot's last one.
  [[nodiscard]] static Outcome<CrclSession> connect(const Endpoints& endpoints,
                                                    const std::string& robot);

  /// Asks for the status and reads it.
  [[nodiscard]] Outcome<crcl::Status> status();

  /// Sends a command under the next id and waits until it is done.
  [[nodiscard]] Outcome<crcl::Status> run(crcl::CommandBody body, Seconds timeout);
  /// The same with all that a document can say. Its id is kept if it is larger than all before.
  [[nodiscard]] Outcome<crcl::Status> run(crcl::CommandInstance instance, Seconds timeout);

  /// Sends a document as it stands, of which `command` has been read, and waits until it is done.
  [[nodiscard]] Outcome<crcl::Status> run_document(const std::string& document,
                                                   const crcl::Command& command, Seconds timeout);

  /// Stops what a command of this session may still move, also after an interruption, and waits
  /// until the robot stands. Nothing when all that was sent has ended.
  [[nodiscard]] Outcome<void> stop();
  /// Stops the robot if the user has interrupted what led to that failure, and tells what came of
  /// it; otherwise the failure itself.
  [[nodiscard]] Failure stopped_after(const Failure& failure);

  [[nodiscard]] const std::string& robot() const { return robot_; }

 private:
  CrclSession(TcpSocket socket, std::string robot);
  [[nodiscard]] Outcome<void> send_raw(const std::string& bytes);
  /// Reads one status that was asked for.
  [[nodiscard]] Outcome<crcl::Status> read_status();
  /// Polls until the status shows that id as done. An error of the robot is kRefused with its
  /// description; another client's command in between is kRefused too.
  [[nodiscard]] Outcome<crcl::Status> wait_done(std::int64_t id, Seconds timeout,
                                                const std::string& what);

  TcpSocket socket_;
  crcl::Framer framer_ = crcl::Framer::for_statuses();
  std::string robot_;
  std::int64_t last_id_ = 0;
  bool under_way_ = false;  // a command was sent and its end not seen
};

}  // namespace aprsim::client
