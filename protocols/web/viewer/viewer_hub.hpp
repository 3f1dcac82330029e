#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "protocols/conveyor/conveyor_device.hpp"
#include "protocols/web/http/web_counts.hpp"
#include "protocols/web/topics/fault_log.hpp"
#include "protocols/web/topics/topic_table.hpp"
#include "protocols/web/viewer/topic_publisher.hpp"
#include "protocols/web/viewer/viewer_access.hpp"
#include "protocols/web/viewer/viewer_requests.hpp"
#include "protocols/web/viewer/viewers.hpp"
#include "protocols/web/viewer/web_options.hpp"

namespace aprsim::web {

/// Admits viewers, dispatches their requests and publishes topics at each tick. Independent of
/// HTTP. Thread: the server's.
class ViewerHub {
 public:
  using Clock = std::chrono::steady_clock;

  ViewerHub(const WebServerOptions& options, api::CommandSink& sink,
            const api::SnapshotSource& source, WebCounts& counts);

  void add(std::shared_ptr<WebSocket> socket, std::string peer, protocols::Caller caller);
  /// Sends the messages that are due. Call it at the highest rate of snapshots.
  void tick(Clock::time_point now);
  /// Ends jogs and closes every viewer.
  void close();
  /// Drops the viewers that have not completed the closing handshake.
  void drop();

 private:
  [[nodiscard]] TopicSources topic_sources();
  void greet(Viewer& viewer);
  /// Sends the viewer its permission if that has changed, and the constant messages once.
  void update_permission(Viewer& viewer, bool first = false);
  void set_watch(Viewer& viewer, const v1::Watch& watch);
  /// Lets the taps keep polls while a viewer watches them.
  void update_taps();
  void remove(Viewer& viewer);
  /// Selects the viewers that receive a snapshot at this tick.
  void schedule_snapshots(const api::SnapshotPtr& snapshot, Clock::time_point now);

  const WebServerOptions& options_;
  const api::SnapshotSource& source_;
  WebCounts& counts_;
  const std::string instance_id_;
  conveyor::ConveyorDevice device_;  // of this reader: registers computed from the snapshot
  FaultLog faults_;
  ViewerAccess access_;
  Viewers viewers_;
  std::uint64_t next_id_ = 0;
  TopicSources topics_;
  TopicPublisher publisher_;
  ViewerRequests requests_;
  api::SnapshotPtr sent_;
  Clock::time_point sent_at_{}, permissions_at_{};
};

}  // namespace aprsim::web
