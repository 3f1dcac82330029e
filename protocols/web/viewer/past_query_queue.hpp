#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "world/api/ports/history.hpp"

namespace aprsim::web {

/// Queue of queries for moments of the past. One query of each viewer is processed at a time; a
/// newer query replaces the one that waits. Thread: the server's.
class PastQueryQueue {
 public:
  struct Query {
    std::uint64_t viewer = 0;
    std::uint32_t request = 0;
    api::Moment moment;
    bool resume = false;  ///< return the cell to this moment; never replaced
  };
  struct Answer {
    Query query;
    Result<api::PastMoment> past;
  };

  explicit PastQueryQueue(api::History* history) : history_(history) {}

  void add(const Query& query);
  /// Answers since the last call.
  [[nodiscard]] std::vector<Answer> take_answers();
  void forget(std::uint64_t viewer) { waiting_.erase(viewer); }

 private:
  /// Outlives the queue while an answer is pending.
  struct Mailbox {
    std::mutex mutex;
    std::vector<Answer> answers;
  };
  void start(const Query& query);

  api::History* history_;
  std::shared_ptr<Mailbox> mailbox_ = std::make_shared<Mailbox>();
  /// Waiting query of each viewer whose previous query is pending.
  std::map<std::uint64_t, std::optional<Query>> waiting_;
};

}  // namespace aprsim::web
