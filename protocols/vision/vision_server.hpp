#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "protocols/net/listener_options.hpp"
#include "world/api/ports/ports.hpp"
#include "world/base/result.hpp"

/// The vision feed of one robot.
namespace aprsim::vision_server {

/// Virtual time waits until every client has taken a frame, and `repeat` is simulated there.
struct VisionServerOptions {
  protocols::ListenerOptions listener{.port = 4000};
  int robot = 0;             ///< index into CellDescription::robots
  bool empty_slots = false;  ///< name what was not detected, see vision_line.hpp
  /// The last frame is repeated after this wall time without a new one: readers time out.
  std::chrono::milliseconds repeat{250};
  /// A connection that has not taken a frame after this time is closed.
  std::chrono::milliseconds write_timeout{4000};
};

struct VisionServerStats {
  std::uint64_t accepted = 0;  ///< connections taken
  std::uint64_t refused = 0;   ///< connections closed at once: over the limit
  std::uint64_t dropped = 0;   ///< connections we ended: peers that take no frames, browsers
  std::uint64_t open = 0;      ///< connections now
  std::uint64_t frames = 0;    ///< new frames from the camera, repetitions left out
  std::uint64_t skipped = 0;   ///< frames not sent to slow clients
};

/// Sends the frames of one robot's camera to any number of clients, as lines of text (see
/// vision_line.hpp), from one thread of its own. A client gets the latest frame when it connects,
/// then each new one. A slow client gets only the latest of the frames that it missed.
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

  /// The robot has this index in another scene. `change` lets the snapshots have it, on the
  /// server's thread. Thread: the owner's, between start and stop.
  void set_robot(int robot, std::function<void()> change);

  /// Thread: any.
  [[nodiscard]] VisionServerStats stats() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::vision_server
