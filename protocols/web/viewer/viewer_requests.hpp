#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "protocols/conveyor/conveyor_device.hpp"
#include "protocols/web/http/web_counts.hpp"
#include "protocols/web/jog/jogger.hpp"
#include "protocols/web/viewer/draft_requests.hpp"
#include "protocols/web/viewer/past_requests.hpp"
#include "protocols/web/viewer/preview_requests.hpp"
#include "protocols/web/viewer/scenario_requests.hpp"
#include "protocols/web/viewer/viewer_access.hpp"
#include "protocols/web/viewer/viewers.hpp"

namespace aprsim::web {

/// Dispatches viewers' requests and answers them, immediately or once the cell has accepted them.
/// Thread: the server's.
class ViewerRequests {
 public:
  using Clock = std::chrono::steady_clock;
  struct Events {
    std::function<void(Viewer&, const v1::Watch&)> watch;
    std::function<void(Viewer&)> authenticated;  ///< its role may have changed
  };
  /// Objects that requests act on; they must outlive this one.
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
  /// Continues jogs. Call it at each tick before the snapshot is sent, so that a jog has ended when
  /// its viewer sees another client's command.
  void tick_jogs(const api::Snapshot& snapshot, Clock::time_point now);
  /// Answers requests that waited for the cell or for a moment of the past.
  void answer_waiting(const api::Snapshot& snapshot);
  /// Whether this command was sent by a jog.
  [[nodiscard]] bool sent_by_jog(int robot, api::Ticket ticket) const {
    const auto index = static_cast<std::size_t>(robot);
    return index < joggers_.size() && joggers_[index].sent(ticket);
  }
  /// Ends the viewer's jogs.
  void release_jogs(const Viewer& viewer);
  /// Ends the viewer's jogs and drops its pending requests.
  void forget(const Viewer& viewer);

 private:
  /// A request whose outcome is read from a later snapshot.
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
  void follow_robots(const std::shared_ptr<const api::CellDescription>& cell);
  void answer_steps(Jogger& jogger);
  [[nodiscard]] Result<void> jog(const Viewer& viewer, const v1::ViewerRequest& request);
  void answer_awaited(const api::Snapshot& snapshot);
  void answer_past(const PastRequests::Answer& answer);
  void answer_preview(const PreviewRequests::Answer& answer);
  [[nodiscard]] Result<void> send_scene(Viewer& viewer, std::uint32_t id);
  void answer_draft(const DraftRequests::Answer& answer);
  [[nodiscard]] Result<void> execute_scenario(Viewer& viewer, const v1::ViewerRequest& request,
                                              Result<void> done);
  [[nodiscard]] Result<void> send_scenario(Viewer& viewer, const v1::ViewerRequest& request);
  void answer_scenario(const ScenarioRequests::Answer& answer);
  void resume(const PastRequests::Answer& answer, Viewer& viewer);

  Context context_;
  Events events_;
  std::vector<Jogger> joggers_;                       // by robot
  std::shared_ptr<const api::CellDescription> cell_;  // that they know
  std::vector<Awaited> awaited_;
  PastRequests past_;
  PreviewRequests previews_;
  DraftRequests drafts_;
  ScenarioRequests scenarios_;
};

}  // namespace aprsim::web
