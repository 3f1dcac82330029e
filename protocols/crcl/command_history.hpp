#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>

#include "world/api/values/ticket.hpp"

namespace aprsim::crcl_server {

/// A command that the world has accepted.
struct Submission {
  api::Ticket ticket = 0;
  bool done_when_applied = false;  ///< else once the robot reports its action done
};

/// Which of a robot's CRCL commands a ticket was, for the latest ones: a saved state brings back
/// the ticket of what the robot was doing. Thread: the server's.
class CommandHistory {
 public:
  struct Entry {
    Submission submission;
    std::int64_t command_id = 0;
    std::string type;  ///< of the command
  };

  /// Tickets rise.
  void add(Entry entry) {
    if (entries_.size() >= kKept) entries_.pop_front();
    entries_.push_back(std::move(entry));
  }

  /// Null when it is none of ours, or long ago.
  [[nodiscard]] const Entry* find(api::Ticket ticket) const {
    const auto at = std::ranges::lower_bound(
        entries_, ticket, {}, [](const Entry& entry) { return entry.submission.ticket; });
    return at != entries_.end() && at->submission.ticket == ticket ? &*at : nullptr;
  }

 private:
  static constexpr std::size_t kKept = 16384;
  std::deque<Entry> entries_;
};

}  // namespace aprsim::crcl_server
