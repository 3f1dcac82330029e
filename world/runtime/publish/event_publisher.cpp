#include "world/runtime/publish/event_publisher.hpp"

#include <memory>
#include <new>
#include <utility>

namespace aprsim::world {

void EventPublisher::assign_event_ids(std::vector<api::CellEvent>& found, std::uint64_t epoch) {
  std::size_t done = 0;
  try {
    pending_.reserve(pending_.size() + found.size());
    for (; done < found.size(); ++done) {
      auto event = std::make_shared<api::CellEvent>(std::move(found[done]));
      event->sequence = ++last_event_;
      event->epoch = epoch;
      pending_.push_back(std::move(event));
      recording_.record_event(pending_.back());
    }
  } catch (const std::bad_alloc&) {
    // The next call takes the rest.
  }
  found.erase(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(done));
}

void EventPublisher::publish_events() {
  if (!pending_.empty()) log_.add(std::exchange(pending_, {}));
}

}  // namespace aprsim::world
