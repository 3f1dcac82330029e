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

/// Keeps the viewers and the time: admits viewers, has their requests answered, and publishes
/// topics at each tick. Knows no HTTP. Thread: the server's.
class ViewerHub {
 public:
  using Clock = std::chrono::steady_clock;

  ViewerHub(const WebServerOptions& options, api::CommandSink& sink,
            const api::SnapshotSource& source, WebCounts& counts);

  void add(std::shared_ptr<WebSocket> socket, std::string peer, protocols::Caller caller);
  /// Sends what is due; at the highest rate of snapshots.
  void tick(Clock::time_point now);
  /// Ends jogs and closes every viewer.
  void close();
  /// Ends the viewers that have not answered the goodbye.
  void drop();

 private:
  [[nodiscard]] TopicSources topic_sources();
  void greet(Viewer& viewer);
  /// Sends the viewer its permission if it differs from the last one, and once what stays.
  void update_permission(Viewer& viewer, bool first = false);
  void set_watch(Viewer& viewer, const v1::Watch& watch);
  /// The taps keep polls while somebody watches them.
  void update_taps();
  void remove(Viewer& viewer);
  /// Decides who gets a snapshot at this tick.
  void schedule_snapshots(const api::SnapshotPtr& snapshot, Clock::time_point now);

  const WebServerOptions& options_;
  const api::SnapshotSource& source_;
  WebCounts& counts_;
  const std::string instance_id_;
  conveyor::ConveyorDevice device_;  // a reader's own: the registers as the snapshot makes them
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
