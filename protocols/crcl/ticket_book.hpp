#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>

#include "world/api/ticket.hpp"

namespace aprsim::protocols {

/// Which of a robot's CRCL commands a ticket was, for the latest ones: a saved state brings back
/// the ticket of what the robot was doing. Thread: the server's.
class TicketBook {
 public:
  struct Entry {
    api::Ticket ticket = 0;
    std::int64_t command_id = 0;
    std::string name;      ///< type of the command
    bool setting = false;  ///< changes no motion
  };

  /// Tickets rise.
  void note(Entry entry) {
    if (entries_.size() >= kKept) entries_.pop_front();
    entries_.push_back(std::move(entry));
  }

  /// Null when it is none of ours, or long ago.
  [[nodiscard]] const Entry* find(api::Ticket ticket) const {
    const auto at = std::ranges::lower_bound(entries_, ticket, {}, &Entry::ticket);
    return at != entries_.end() && at->ticket == ticket ? &*at : nullptr;
  }

 private:
  static constexpr std::size_t kKept = 16384;
  std::deque<Entry> entries_;
};

}  // namespace aprsim::protocols
