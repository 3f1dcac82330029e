#include "protocols/web/viewer/past_query_queue.hpp"

#include <utility>

namespace aprsim::web {

void PastQueryQueue::add(const Query& query) {
  if (query.resume) return start(query);
  const auto [found, first] = waiting_.try_emplace(query.viewer);
  if (!first) {
    found->second = query;
    return;
  }
  start(query);
}

void PastQueryQueue::start(const Query& query) {
  history_->ask(query.moment, [mailbox = mailbox_, query](Result<api::PastMoment> past) {
    const std::lock_guard lock(mailbox->mutex);
    mailbox->answers.push_back({query, std::move(past)});
  });
}

std::vector<PastQueryQueue::Answer> PastQueryQueue::take_answers() {
  std::vector<Answer> answers;
  {
    const std::lock_guard lock(mailbox_->mutex);
    answers.swap(mailbox_->answers);
  }
  for (const Answer& answer : answers) {
    if (answer.query.resume) continue;
    const auto found = waiting_.find(answer.query.viewer);
    if (found == waiting_.end()) continue;
    const std::optional<Query> next = std::exchange(found->second, std::nullopt);
    if (next) {
      start(*next);
    } else {
      waiting_.erase(found);
    }
  }
  return answers;
}

}  // namespace aprsim::web
