#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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
    std::string_view type;  ///< of the command; a name of crcl::type_name()
    std::string name;  ///< of its status; empty = its type, so that most entries need no memory
  };

  /// Tickets rise.
  void add(Entry entry) {
    entries_[next_] = std::move(entry);
    next_ = (next_ + 1) % kKept;
    count_ = std::min(count_ + 1, kKept);
  }

  /// Null if the ticket belongs to another interface, or is too old.
  [[nodiscard]] const Entry* find(api::Ticket ticket) const {
    std::size_t first = 0;
    for (std::size_t end = count_; first < end;) {
      const std::size_t middle = first + (end - first) / 2;
      if (at(middle).submission.ticket < ticket) {
        first = middle + 1;
      } else {
        end = middle;
      }
    }
    return first < count_ && at(first).submission.ticket == ticket ? &at(first) : nullptr;
  }

 private:
  static constexpr std::size_t kKept = 16384;
  /// 0 = the oldest.
  [[nodiscard]] const Entry& at(std::size_t index) const {
    return entries_[(next_ + kKept - count_ + index) % kKept];
  }

  std::vector<Entry> entries_ = std::vector<Entry>(kKept);  ///< a ring, allocated at once
  std::size_t next_ = 0, count_ = 0;
};

}  // namespace aprsim::crcl_server
