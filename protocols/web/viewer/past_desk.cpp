#include "protocols/web/viewer/past_desk.hpp"

#include <utility>

namespace aprsim::web {

void PastDesk::ask(const Question& question) {
  if (question.resume) return pass_on(question);
  const auto [found, first] = waiting_.try_emplace(question.viewer);
  if (!first) {
    found->second = question;
    return;
  }
  pass_on(question);
}

void PastDesk::pass_on(const Question& question) {
  history_->ask(question.moment, [mailbox = mailbox_, question](Result<api::PastMoment> past) {
    const std::lock_guard lock(mailbox->mutex);
    mailbox->answers.push_back({question, std::move(past)});
  });
}

std::vector<PastDesk::Answer> PastDesk::take() {
  std::vector<Answer> answers;
  {
    const std::lock_guard lock(mailbox_->mutex);
    answers.swap(mailbox_->answers);
  }
  for (const Answer& answer : answers) {
    if (answer.question.resume) continue;
    const auto found = waiting_.find(answer.question.viewer);
    if (found == waiting_.end()) continue;
    const std::optional<Question> next = std::exchange(found->second, std::nullopt);
    if (next) {
      pass_on(*next);
    } else {
      waiting_.erase(found);
    }
  }
  return answers;
}

}  // namespace aprsim::web
