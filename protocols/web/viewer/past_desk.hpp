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
class PastDesk {
 public:
  struct Question {
    std::uint64_t viewer = 0;
    std::uint32_t request = 0;
    api::Moment moment;
    bool resume = false;  ///< the cell is to be put back there; such a one is never left out
  };
  struct Answer {
    Question question;
    Result<api::PastMoment> past;
  };

  explicit PastDesk(api::History* history) : history_(history) {}

  void ask(const Question& question);
  /// What has been answered since the last call.
  [[nodiscard]] std::vector<Answer> take();
  void forget(std::uint64_t viewer) { waiting_.erase(viewer); }

 private:
  /// Outlives the desk while an answer is on its way.
  struct Mailbox {
    std::mutex mutex;
    std::vector<Answer> answers;
  };
  void pass_on(const Question& question);

  api::History* history_;
  std::shared_ptr<Mailbox> mailbox_ = std::make_shared<Mailbox>();
  /// By viewer with one on its way: what is next.
  std::map<std::uint64_t, std::optional<Question>> waiting_;
};

}  // namespace aprsim::web
