#include "protocols/simple_message/stream_ends.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::simple_message {

void StreamEnds::expect(api::Ticket stream, std::string peer) {
  stream_ = stream;
  peer_ = std::move(peer);
}

void StreamEnds::report(const api::Snapshot& now, const api::RobotSnapshot& robot) {
  if (stream_ == 0 || now.applied < stream_) return;
  const auto& ends = robot.motion.ends;
  if (!ends) return;
  const auto end = std::ranges::find(*ends, stream_, &api::StreamEnd::stream);
  if (end == ends->end()) return;
  stream_ = 0;
  if (end->result == api::StreamResult::kAlarm) {
    log_.warn(peer_ + ": its motion ends in an alarm: " + end->text);
  } else if (end->result == api::StreamResult::kStopped) {
    log_.warn(peer_ + ": its motion is stopped: " + end->text);
  }
}

}  // namespace aprsim::simple_message
