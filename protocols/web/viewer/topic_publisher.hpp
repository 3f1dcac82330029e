#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "protocols/web/topics/topic.hpp"
#include "protocols/web/viewer/viewer.hpp"

namespace aprsim::web {

/// Sends each viewer the topics that it has not seen in their present revision. A message that is
/// the same for all is built once a round, and only if somebody gets it. Thread: the server's.
class TopicPublisher {
 public:
  using Clock = Topic::Clock;

  explicit TopicPublisher(std::vector<Topic> topics);

  /// Publishes what is due; call it at each tick.
  void publish(const std::vector<std::shared_ptr<Viewer>>& viewers, Clock::time_point now);

 private:
  struct Entry {
    Topic topic;
    std::size_t index = 0;  ///< into Viewer::seen
    Clock::time_point last_round{};
  };
  /// One topic at one tick.
  struct Round {
    bool due = false;  ///< for viewers that have some revision already
    std::optional<Topic::Revision> revision;
    WebMessage message;  ///< once it has been built
  };

  void publish(Entry& entry, const std::vector<std::shared_ptr<Viewer>>& viewers,
               Clock::time_point now);
  void send(const Entry& entry, Round& round, Viewer& viewer);
  void send_own(const Entry& entry, Viewer& viewer);
  /// Whether it was sent.
  bool deliver(const Entry& entry, Viewer& viewer, const WebMessage& message);

  std::vector<Entry> entries_;
  v1::ViewerUpdate update_;  // keeps its memory from message to message
};

}  // namespace aprsim::web
