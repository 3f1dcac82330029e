#include "world/runtime/history/past_states.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::world {

void PastStates::keep(api::Moment moment, std::shared_ptr<const WorldState> state) {
  if (find(moment)) return;
  bytes_ += state->bytes();
  kept_.push_front({moment, std::move(state)});
  while (bytes_ > max_bytes_ && kept_.size() > 1) {
    bytes_ -= kept_.back().state->bytes();
    kept_.pop_back();
  }
}

PastStates::Kept PastStates::latest(api::Moment first, api::Moment moment) {
  auto best = kept_.end();
  for (auto it = kept_.begin(); it != kept_.end(); ++it) {
    if (it->moment < first || it->moment > moment) continue;
    if (best == kept_.end() || it->moment > best->moment) best = it;
  }
  if (best == kept_.end()) return {};
  kept_.splice(kept_.begin(), kept_, best);
  return kept_.front();
}

std::shared_ptr<const WorldState> PastStates::find(api::Moment moment) const {
  const auto found = std::ranges::find(kept_, moment, &Kept::moment);
  return found == kept_.end() ? nullptr : found->state;
}

}  // namespace aprsim::world
