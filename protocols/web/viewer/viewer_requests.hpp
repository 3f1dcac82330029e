#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "protocols/conveyor/conveyor_device.hpp"
#include "protocols/web/http/web_counts.hpp"
#include "protocols/web/jog/jogger.hpp"
#include "protocols/web/viewer/past_requests.hpp"
#include "protocols/web/viewer/viewer_access.hpp"
#include "protocols/web/viewer/viewers.hpp"

namespace aprsim::web {

/// Dispatches the requests of viewers and answers them: at once, or when the cell has taken them.
/// Thread: the server's.
class ViewerRequests {
 public:
  using Clock = std::chrono::steady_clock;
  struct Events {
    std::function<void(Viewer&, const v1::Watch&)> watch;
    std::function<void(Viewer&)> authenticated;  ///< its role may be another one
  };
  /// Everything that requests are about. The objects outlive this one.
  struct Context {
    const WebServerOptions& options;
    api::CommandSink& sink;
    const api::SnapshotSource& source;
    const std::string& instance_id;
    const Viewers& viewers;
    ViewerAccess& access;
    conveyor::ConveyorDevice& device;
    WebCounts& counts;
  };

  ViewerRequests(Context context, Events events);

  void answer(Viewer& viewer, const v1::ViewerRequest& request);
  /// Goes on with jogs; call it at each tick, before viewers are sent the snapshot: a viewer that
  /// has seen another client's command take a robot over finds its jog ended.
  void tick_jogs(const api::Snapshot& snapshot, Clock::time_point now);
  /// Answers what has been waiting for the cell or for the past.
  void answer_waiting(const api::Snapshot& snapshot);
  /// Whether a jog has sent this command.
  [[nodiscard]] bool sent_by_jog(int robot, api::Ticket ticket) const {
    return joggers_[static_cast<std::size_t>(robot)].sent(ticket);
  }
  /// Ends the viewer's jogs.
  void release_jogs(const Viewer& viewer);
  /// The same, and it asks for nothing any more.
  void forget(const Viewer& viewer);

 private:
  /// A request whose outcome shows in a snapshot.
  struct Awaited {
    std::uint64_t viewer = 0;
    std::uint32_t request = 0;
    api::Ticket ticket = 0;
    Clock::time_point asked{};
  };

  [[nodiscard]] Result<void> execute(Viewer& viewer, const v1::ViewerRequest& request);
  [[nodiscard]] Result<void> authenticate(Viewer& viewer, const std::string& token);
  [[nodiscard]] Result<void> command(Viewer& viewer, const v1::ViewerRequest& request);
  [[nodiscard]] Result<void> command_world(const Viewer& viewer, const v1::ViewerRequest& request);
  [[nodiscard]] Result<void> command_programs(const v1::ViewerRequest& request);
  [[nodiscard]] Result<void> write_register(const v1::WriteRegister& write);
  [[nodiscard]] Result<void> jog(const Viewer& viewer, const v1::ViewerRequest& request);
  void answer_awaited(const api::Snapshot& snapshot);
  void answer_past(const PastRequests::Answer& answer);
  void resume(const PastRequests::Answer& answer, Viewer& viewer);

  Context context_;
  Events events_;
  std::vector<Jogger> joggers_;  // by robot
  std::vector<Awaited> awaited_;
  PastRequests past_;
};

}  // namespace aprsim::web
