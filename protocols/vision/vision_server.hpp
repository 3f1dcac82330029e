#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "protocols/net/connection_places.hpp"
#include "protocols/ports/refusal_sink.hpp"
#include "protocols/record/wire_trace.hpp"
#include "world/api/ports/ports.hpp"
#include "world/api/ports/virtual_time.hpp"
#include "world/base/result.hpp"

/// The vision feed of one robot.
namespace aprsim::vision_server {

struct VisionServerOptions {
  std::string bind_address = "127.0.0.1";  ///< a numeric IPv4 or IPv6 address
  std::uint16_t port = 4000;               ///< 0 = any free port
  int robot = 0;                           ///< index into CellDescription::robots
  protocols::ConnectionLimits limits;      ///< a connection without a place is closed at once
  /// Networks or addresses that are served, "192.168.1.0/24"; others are closed at once. None =
  /// whoever reaches the bind address.
  std::vector<std::string> allow = {};
  bool empty_slots = false;  ///< name what was not detected, see vision_line.hpp
  /// A frame that no other follows is sent again after so long, in wall time: readers time out.
  std::chrono::milliseconds repeat{250};
  /// A connection that has not taken a frame after so long is closed.
  std::chrono::milliseconds write_timeout{4000};
  /// stop() lets frames under way go out for at most so long.
  std::chrono::milliseconds drain_deadline{500};
  /// Time waits until every client has taken a frame, and `repeat` is simulated; null = the wall
  /// clock passes time. Outlives the server.
  api::VirtualTime* virtual_time = nullptr;
  protocols::WireTrace* trace = nullptr;       ///< hears of everything; outlives the server
  protocols::RefusalSink* refusals = nullptr;  ///< hears what is refused; outlives the server
};

struct VisionServerStats {
  std::uint64_t accepted = 0;  ///< connections taken
  std::uint64_t refused = 0;   ///< connections closed at once: over the limit
  std::uint64_t dropped = 0;   ///< connections we ended: peers that take no frames, browsers
  std::uint64_t open = 0;      ///< connections now
  std::uint64_t frames = 0;    ///< new frames from the camera, repetitions left out
  std::uint64_t skipped = 0;   ///< frames that slow clients did not get
};

/// Sends the frames of one robot's camera to any number of clients, as lines of text (see
/// vision_line.hpp), from one thread of its own. A client gets the latest frame when it connects,
/// then each new one; a slow client only the latest of those that it could not take.
class VisionServer {
 public:
  /// Keeps a reference to the source, which must outlive the server.
  VisionServer(VisionServerOptions options, const api::SnapshotSource& source);
  ~VisionServer();
  VisionServer(const VisionServer&) = delete;
  VisionServer& operator=(const VisionServer&) = delete;

  /// Listens and starts the thread; returns the port. Fails with the address, port and cause.
  /// Once only. Thread: the owner's.
  [[nodiscard]] Result<std::uint16_t> start();
  /// Takes no more connections, lets frames under way go out until the drain deadline, closes
  /// everything and joins. Again: nothing. Thread: the owner's.
  void stop();

  /// Thread: any.
  [[nodiscard]] VisionServerStats stats() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::vision_server
