#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "aprsim/v1/web.pb.h"
#include "protocols/conveyor/conveyor_device.hpp"
#include "protocols/net/limited_log.hpp"
#include "protocols/web/http/web_counts.hpp"
#include "protocols/web/jog/jogger.hpp"
#include "protocols/web/topics/fault_log.hpp"
#include "protocols/web/topics/scene_looks.hpp"
#include "protocols/web/viewer/past_desk.hpp"
#include "protocols/web/viewer/viewer.hpp"
#include "protocols/web/viewer/web_options.hpp"

namespace aprsim::web {

/// All viewers: what each is sent when, and what becomes of its requests. Knows no HTTP.
/// Thread: the server's.
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
  [[nodiscard]] std::size_t size() const { return viewers_.size(); }

 private:
  /// A request whose outcome shows in a snapshot.
  struct Awaited {
    std::uint64_t viewer = 0;
    std::uint32_t request = 0;
    api::Ticket ticket = 0;
    Clock::time_point asked{};
  };

  void answer(Viewer& viewer, const v1::ViewerRequest& request);
  void answer_awaited(const api::Snapshot& snapshot);
  static void send_outcome(Viewer& viewer, std::uint32_t id, const Result<void>& done);
  [[nodiscard]] Result<void> execute(Viewer& viewer, const v1::ViewerRequest& request);
  [[nodiscard]] Result<void> command(Viewer& viewer, const v1::ViewerRequest& request);
  [[nodiscard]] Result<void> command_programs(const v1::ViewerRequest& request);
  [[nodiscard]] Result<void> write_register(const v1::WriteRegister& write);
  /// What concerns the past; absent = nothing does.
  [[nodiscard]] std::optional<Result<void>> command_history(const Viewer& viewer,
                                                            const v1::ViewerRequest& request);
  void answer_past();
  void send_history(Clock::time_point now);
  /// Puts what a viewer asks of the cell, and whether it was taken, among the wires' commands.
  void note(Viewer& viewer, const v1::ViewerRequest& request, const Result<void>& done);
  void refused(const std::string& what);
  [[nodiscard]] Result<void> authenticate(Viewer& viewer, const std::string& token);
  void set_watch(Viewer& viewer, const v1::Watch& watch);
  void remove(Viewer& viewer);
  void update_taps();

  /// Whether there is anything that a viewer may command.
  [[nodiscard]] bool commands() const { return options_.control && options_.read_only.empty(); }
  /// What the viewer may now.
  [[nodiscard]] protocols::Role role_of(const Viewer& viewer) const;
  [[nodiscard]] v1::Permission permission(const Viewer& viewer) const;
  /// Why it may not ask for this; no error = it may.
  [[nodiscard]] Result<void> check_role(const Viewer& viewer, const std::string& request);
  void greet(Viewer& viewer);
  /// Sends what it may: its permission if that is another than before, and once what stays.
  void update_permission(Viewer& viewer, bool first = false);
  void send_snapshots(const api::SnapshotPtr& snapshot, Clock::time_point now);
  /// The description, after the looks where the viewer has others.
  void send_cell(Viewer& viewer, const std::shared_ptr<const api::CellDescription>& cell,
                 WebMessage& message);
  void send_registers();
  void send_status();
  void send_faults(Clock::time_point now);
  void send_programs(Clock::time_point now);
  void send_events(protocols::WireTap* tap, const char* wire, bool (v1::Watch::*wants)() const,
                   std::uint64_t Viewer::Next::*next);
  template <typename Visit>
  void for_each(const Visit& visit);
  /// The same of those that may look.
  template <typename Visit>
  void for_each_that_looks(const Visit& visit);

  const WebServerOptions& options_;
  api::CommandSink& sink_;
  const api::SnapshotSource& source_;
  WebCounts& counts_;
  std::string instance_id_;
  int beams_ = 0;  // of the light curtain; the same after a reset
  SceneLooks looks_, past_looks_;
  WebMessage looks_message_;  // of the former
  modbus_server::ConveyorDevice
      device_;  // a reader's own: the registers as the snapshot makes them
  std::map<std::uint64_t, std::shared_ptr<Viewer>> viewers_;
  std::uint64_t next_id_ = 0;
  std::vector<Jogger> joggers_;  // by robot
  std::vector<Awaited> awaited_;
  FaultLog faults_;
  PastDesk past_;
  protocols::LimitedLog log_{"web"};
  api::SnapshotPtr sent_;
  Clock::time_point sent_at_{}, registers_at_{}, status_at_{}, faults_at_{}, programs_at_{},
      history_at_{}, bookmarks_at_{};
  v1::ViewerUpdate update_;  // keeps its memory from message to message
  std::vector<protocols::WireEventPtr> events_;
};

}  // namespace aprsim::web
