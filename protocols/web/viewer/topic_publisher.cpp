#include "protocols/web/viewer/topic_publisher.hpp"

#include <utility>

namespace aprsim::web {
namespace {

Audience audience_of(const Viewer& viewer) {
  return {viewer.watch, viewer.snapshot_due, viewer.idle(), viewer.skipped_snapshots};
}

}  // namespace

TopicPublisher::TopicPublisher(std::vector<Topic> topics) {
  for (Topic& topic : topics) entries_.push_back({std::move(topic), entries_.size()});
}

void TopicPublisher::publish(const std::vector<std::shared_ptr<Viewer>>& viewers,
                             Clock::time_point now) {
  for (const auto& viewer : viewers) viewer->seen.resize(entries_.size());
  for (Entry& entry : entries_) publish(entry, viewers, now);
}

void TopicPublisher::publish(Entry& entry, const std::vector<std::shared_ptr<Viewer>>& viewers,
                             Clock::time_point now) {
  const Topic& topic = entry.topic;
  Round round;
  round.due = now - entry.last_round >= topic.period;
  if (!round.due && !topic.first_at_once) return;
  if (round.due) entry.last_round = now;
  if (topic.revision) round.revision = topic.revision();
  for (const auto& viewer : viewers) {
    if (viewer->role >= topic.role) send(entry, round, *viewer);
  }
}

void TopicPublisher::send(const Entry& entry, Round& round, Viewer& viewer) {
  const Topic& topic = entry.topic;
  std::optional<Topic::Revision>& seen = viewer.seen[entry.index];
  if (!round.due && seen) return;
  if (round.revision && seen == round.revision) return;
  if (topic.wanted && !topic.wanted(audience_of(viewer))) return;
  if (topic.write_own) return send_own(entry, viewer);
  if (!round.message) {
    update_.Clear();
    topic.write(update_);
    round.message = pack(update_);
  }
  if (deliver(entry, viewer, round.message)) seen = round.revision;
}

void TopicPublisher::send_own(const Entry& entry, Viewer& viewer) {
  std::optional<Topic::Revision>& seen = viewer.seen[entry.index];
  update_.Clear();
  seen = entry.topic.write_own(audience_of(viewer), seen, update_);
  if (update_.body_case() != v1::ViewerUpdate::BODY_NOT_SET) {
    (void)deliver(entry, viewer, pack(update_));
  }
}

bool TopicPublisher::deliver(const Entry& entry, Viewer& viewer, const WebMessage& message) {
  switch (entry.topic.delivery) {
    case Topic::Delivery::kIfQuick:
      return viewer.send_if_quick(message);
    case Topic::Delivery::kLatest:
      if (!viewer.send_latest(entry.index, message) && entry.topic.on_skipped) {
        ++viewer.skipped_snapshots;
        entry.topic.on_skipped();
      }
      return true;
    case Topic::Delivery::kMust:
      break;
  }
  viewer.send(message);
  return true;
}

}  // namespace aprsim::web
