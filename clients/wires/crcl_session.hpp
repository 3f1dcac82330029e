#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "clients/wires/cancellation.hpp"
#include "clients/wires/endpoints.hpp"
#include "clients/wires/outcome.hpp"
#include "clients/wires/tcp_socket.hpp"
#include "crcl/documents.hpp"
#include "crcl/framer.hpp"
#include "crcl/status.hpp"

namespace aprsim::client {

/// One CRCL connection to a robot, used as the reference clients use it: a command is sent and gets
/// no answer; its progress is read by polling the status until that reports its id as done.
///
/// Values are in the units of the connection, which are millimetres and degrees until a SetUnits
/// command changes them; poses are in the robot's own frame. Failures: kConnection when the wire
/// breaks, kRefused with the robot's own words, kTimeout, kInterrupted. Thread: one at a time.
class CrclSession {
 public:
  using Seconds = std::chrono::duration<double>;

  /// Connects to the robot of that name and reads the status once, to number commands on from the
  /// robot's last one. `cancelled` ends every later call but stop().
  [[nodiscard]] static Outcome<CrclSession> connect(const Endpoints& endpoints,
                                                    const std::string& robot,
                                                    Cancelled cancelled = {});

  /// Asks for the status and reads it.
  [[nodiscard]] Outcome<crcl::Status> status();

  /// Sends a command under the next id and waits until it is done. The robot goes on with a command
  /// that is not done in time.
  [[nodiscard]] Outcome<crcl::Status> run(crcl::CommandBody body, Seconds timeout);
  /// The same with everything that a document can say. Its id is kept if it is larger than all
  /// before.
  [[nodiscard]] Outcome<crcl::Status> run(crcl::CommandInstance instance, Seconds timeout);

  /// Sends a document as it stands and waits until it is done; `command` is its content.
  [[nodiscard]] Outcome<crcl::Status> run_document(const std::string& document,
                                                   const crcl::Command& command, Seconds timeout);

  /// Stops what a command of this session may still move and waits until the robot stands; cannot
  /// be cancelled. Does nothing when every command sent has ended.
  [[nodiscard]] Outcome<void> stop();
  /// After a cancelled call: stops the robot and reports the result. After any other failure: that
  /// failure.
  [[nodiscard]] Failure stopped_after(const Failure& failure);

  /// The robot's name.
  [[nodiscard]] const std::string& robot() const { return robot_; }

 private:
  CrclSession(TcpSocket socket, std::string robot, Cancelled cancelled);
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
  Cancelled cancelled_;
  std::int64_t last_id_ = 0;
  bool under_way_ = false;  // a command was sent and its end not seen
};

}  // namespace aprsim::client
