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

/// The latest CRCL commands of a robot by ticket: a saved state contains the ticket of the robot's
/// command. Thread: the server's.
class CommandHistory {
 public:
  struct Entry {
    Submission submission;
    std::int64_t command_id = 0;
    std::string type;                 ///< of the command
    std::optional<std::string> name;  ///< of its status
  };

  /// Tickets rise.
  void add(Entry entry) {
    if (entries_.size() >= kKept) entries_.pop_front();
    entries_.push_back(std::move(entry));
  }

  /// Null if the ticket belongs to another interface, or is too old.
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
