#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "clients/wires/cancellation.hpp"
#include "clients/wires/endpoints.hpp"
#include "clients/wires/outcome.hpp"
#include "clients/wires/tcp_socket.hpp"
#include "clients/wires/vision_frame.hpp"

namespace aprsim::client {

/// The feed of a robot's overhead camera: the latest frame when it connects, then each new one.
/// A reader that is slow gets the latest of the frames that it could not take.
///
/// Failures: kConnection when the wire breaks or sends invalid data, kTimeout, kInterrupted.
/// Thread: one at a time.
class VisionFeed {
 public:
  /// Connects to the camera of the robot of that name. `cancelled` ends every later call.
  [[nodiscard]] static Outcome<VisionFeed> connect(const Endpoints& endpoints,
                                                   const std::string& robot,
                                                   Cancelled cancelled = {});

  /// Waits for the next frame and reads it. The daemon repeats a frame that no other follows.
  [[nodiscard]] Outcome<std::vector<VisionObject>> next(std::chrono::milliseconds timeout);

 private:
  VisionFeed(TcpSocket socket, Cancelled cancelled);

  TcpSocket socket_;
  Cancelled cancelled_;
  std::string received_;  // not yet read
};

}  // namespace aprsim::client
