#include "clients/ros2/bridge.hpp"

#include <chrono>
#include <cstdint>
#include <iostream>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "clients/wires/cell_connection.hpp"

namespace aprsim::ros2 {
namespace {

constexpr std::chrono::seconds kRetryPeriod{1};

/// Chooses the samples that frames are published with.
class FrameSelection {
 public:
  FrameSelection(double rate_hz, double tf_rate_hz) : share_(tf_rate_hz / rate_hz) {}
  bool next() {
    sum_ += share_;
    if (sum_ < 1) return false;
    sum_ = share_ < 1 ? sum_ - 1 : 0;
    return true;
  }

 private:
  double share_;
  double sum_ = 1;
};

void set_cell(const BridgeParts& parts, const client::Endpoints& daemon,
              const v1::CellDescription& cell) {
  parts.publisher.set_cell(cell);
  parts.cameras.set_cell(daemon, cell);
  parts.trays.set_cell(daemon, cell);
  parts.actions.set_cell(daemon, cell);
  parts.services.set_daemon(daemon);
}

/// Publishes a snapshot. Throws errors of the parts' threads.
void publish(const BridgeParts& parts, const v1::Snapshot& snapshot, bool with_frames) {
  parts.actions.check();
  parts.services.check();
  parts.actions.set_time(snapshot.sim_time());
  parts.services.set_time(snapshot.sim_time());
  parts.publisher.publish(snapshot, with_frames);
  parts.cameras.update();
  parts.trays.update(snapshot);
}

/// Publishes until the stream ends or is cancelled. Sets `connected` once the daemon has answered.
client::Outcome<void> publish_cell(const BridgeOptions& options, const client::Endpoints& endpoints,
                                   const BridgeParts& parts, const client::Cancelled& cancelled,
                                   bool& connected) {
  client::CellConnection connection(endpoints);
  auto cell = connection.cell();
  if (!cell) return tl::unexpected(cell.error());
  set_cell(parts, endpoints, *cell);
  connected = true;
  std::cout << fmt::format("aprsim-ros2: publishing scene {} of {}: {} robots, {} bodies\n",
                           cell->scene(), client::host_and_port(endpoints.host, endpoints.grpc),
                           cell->robots_size(), cell->bodies_size())
            << std::flush;
  FrameSelection frames(options.rate_hz, options.tf_rate_hz);
  std::optional<std::uint64_t> revision;
  client::Outcome<void> read = {};
  auto done = connection.stream(options.rate_hz, [&](const auto& sample) {
    if (client::is_cancelled(cancelled)) return false;
    const auto& snapshot = sample.snapshot();
    if (revision != snapshot.revision()) {  // also the first one: the cell may have changed
      cell = connection.cell();
      if (!cell) {
        read = tl::unexpected(cell.error());
        return false;
      }
      set_cell(parts, endpoints, *cell);
    }
    revision = snapshot.revision();
    publish(parts, snapshot, frames.next());
    return true;
  });
  return read ? done : read;
}

}  // namespace

client::Outcome<void> run_bridge(const BridgeOptions& options, const BridgeParts& parts,
                                 const client::Cancelled& cancelled) {
  std::string reported;
  bool is_first = true;
  while (!client::is_cancelled(cancelled)) {
    // A daemon that starts anew may have other ports.
    const auto endpoints = client::find_endpoints(options.endpoints);
    if (!endpoints && is_first) return tl::unexpected(endpoints.error());
    is_first = false;
    bool connected = false;
    client::Outcome<void> done =
        endpoints ? publish_cell(options, *endpoints, parts, cancelled, connected)
                  : client::Outcome<void>(tl::unexpected(endpoints.error()));
    if (client::is_cancelled(cancelled)) break;
    parts.actions.disconnect();
    parts.services.disconnect();
    const std::string cause = done ? "the daemon has ended its stream" : done.error().message;
    if (connected || cause != reported) std::cerr << "aprsim-ros2: " << cause << "; trying again\n";
    reported = cause;
    client::sleep_until(std::chrono::steady_clock::now() + kRetryPeriod, cancelled);
  }
  return {};
}

}  // namespace aprsim::ros2
