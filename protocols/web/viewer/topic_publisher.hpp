#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "protocols/web/topics/topic.hpp"
#include "protocols/web/viewer/viewer.hpp"

namespace aprsim::web {

/// Sends each viewer the topics whose revision has changed since its last message. A message common
/// to all viewers is built once a round, and only if it is sent. Thread: the server's.
class TopicPublisher {
 public:
  using Clock = Topic::Clock;

  explicit TopicPublisher(std::vector<Topic> topics);

  /// Publishes the topics that are due. Call it at each tick.
  void publish(const std::vector<std::shared_ptr<Viewer>>& viewers, Clock::time_point now);

 private:
  struct Entry {
    Topic topic;
    std::size_t index = 0;  ///< into Viewer::seen
    Clock::time_point last_round{};
  };
  /// One topic at one tick.
  struct Round {
    bool due = false;  ///< for viewers that have received the topic before
    std::optional<Topic::Revision> revision;
    WebMessage message;  ///< null until it is built
  };

  void publish(Entry& entry, const std::vector<std::shared_ptr<Viewer>>& viewers,
               Clock::time_point now);
  void send(const Entry& entry, Round& round, Viewer& viewer);
  void send_own(const Entry& entry, Viewer& viewer);
  /// Returns whether it was sent.
  bool deliver(const Entry& entry, Viewer& viewer, const WebMessage& message);

  std::vector<Entry> entries_;
  v1::ViewerUpdate update_;  // reused, so that its memory is allocated once
};

}  // namespace aprsim::web
