#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "world/api/ports/history.hpp"

namespace aprsim::web {

/// Where viewers ask for moments of the past: of each one is worked out at a time, and of those
/// that it asks for meanwhile the last one is next. Thread: the server's.
class PastQueryQueue {
 public:
  struct Query {
    std::uint64_t viewer = 0;
    std::uint32_t request = 0;
    api::Moment moment;
    bool resume = false;  ///< the cell is to be put back there; such a one is never left out
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
  /// Outlives the queue while an answer is on its way.
  struct Mailbox {
    std::mutex mutex;
    std::vector<Answer> answers;
  };
  void start(const Query& query);

  api::History* history_;
  std::shared_ptr<Mailbox> mailbox_ = std::make_shared<Mailbox>();
  /// The next query of each viewer with one on its way.
  std::map<std::uint64_t, std::optional<Query>> waiting_;
};

}  // namespace aprsim::web
