#pragma once

#include <string>
#include <utility>

#include "protocols/net/limited_log.hpp"
#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::simple_message {

/// Tells the log why a motion has ended before its last point: an alarm, or a stop of the robot.
/// Each stream's end once, with its latest client. Thread: the listener's.
class StreamEnds {
 public:
  explicit StreamEnds(protocols::LimitedLog& log) : log_(log) {}

  /// The client that commands from now on.
  void commanded_by(std::string peer) { peer_ = std::move(peer); }
  /// A stream that `peer` has begun.
  void expect(api::Ticket stream, std::string peer);
  /// Logs the end of the expected stream, if it is there. `robot`: that of the snapshot.
  void report(const api::Snapshot& now, const api::RobotSnapshot& robot);

 private:
  protocols::LimitedLog& log_;
  api::Ticket stream_ = 0;  // 0 = none
  std::string peer_;
};

}  // namespace aprsim::simple_message
