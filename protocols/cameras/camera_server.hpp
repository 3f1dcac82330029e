#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "protocols/net/listener_options.hpp"
#include "protocols/ports/camera_pictures.hpp"
#include "world/base/result.hpp"

/// The pictures of one camera over HTTP, as cameras of Axis serve them.
namespace aprsim::camera_server {

struct CameraServerOptions {
  protocols::ListenerOptions listener{.port = 8090};
  std::string camera;  ///< its name
  /// A client that has not sent its request, or not taken a picture, after this time is closed.
  std::chrono::milliseconds timeout{10'000};
};

struct CameraServerStats {
  std::uint64_t accepted = 0;  ///< connections taken
  std::uint64_t refused = 0;   ///< connections closed at once: over the limit
  std::uint64_t dropped = 0;   ///< connections we ended: peers that take no pictures
  std::uint64_t open = 0;      ///< connections now
  std::uint64_t pictures = 0;  ///< taken from the camera
  std::uint64_t skipped = 0;   ///< not sent to slow clients
};

/// Sends pictures to any number of clients, from one thread of its own: a stream at the camera's
/// rate (MJPEG), or one at a time. While nobody is connected, no picture is taken. A slow client
/// gets the latest of the pictures that it missed. A paused cell keeps sending.
class CameraServer {
 public:
  /// Keeps a reference to the pictures, which must outlive the server.
  CameraServer(CameraServerOptions options, protocols::CameraPictures& pictures);
  ~CameraServer();
  CameraServer(const CameraServer&) = delete;
  CameraServer& operator=(const CameraServer&) = delete;

  /// Listens and starts the thread; returns the port. Fails with the address, port and cause.
  /// Once only. Thread: the owner's.
  [[nodiscard]] Result<std::uint16_t> start();
  /// Takes no more connections, closes all and joins. Again: nothing. Thread: the owner's.
  void stop();

  /// Thread: any.
  [[nodiscard]] CameraServerStats stats() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::camera_server
