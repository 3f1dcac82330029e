#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "protocols/cameras/camera_server.hpp"
#include "protocols/ports/camera_pictures.hpp"
#include "world/base/result.hpp"

namespace aprsim::server {

/// The listeners of the present scene's cameras, by name. Where another scene is loaded, listeners
/// open and close; a camera of the same name with the same port keeps its own.
class CameraListeners {
 public:
  /// Options of the camera with this name at this place in the scene.
  using MakeOptions =
      std::function<camera_server::CameraServerOptions(std::size_t place, const std::string& name)>;
  using Ports = std::map<std::string, std::uint16_t>;

  /// The pictures outlive it.
  CameraListeners(protocols::CameraPictures& pictures, MakeOptions make_options);
  ~CameraListeners();
  CameraListeners(const CameraListeners&) = delete;
  CameraListeners& operator=(const CameraListeners&) = delete;

  /// Opens those of the present scene. Error: that of the first that cannot listen; its field is
  /// the camera's name. Once only.
  [[nodiscard]] Result<void> start();
  /// Follows the present scene: returns whether something was opened or closed. One that cannot
  /// listen is logged. Thread: one.
  bool update();
  /// Closes all, and every later update() does nothing. Thread: the owner's.
  void stop();

  /// Thread: any.
  [[nodiscard]] Ports ports() const;
  [[nodiscard]] std::map<std::string, camera_server::CameraServerStats> stats() const;

 private:
  struct Listener {
    std::unique_ptr<camera_server::CameraServer> server;
    std::string address;
    std::uint16_t wanted = 0;  ///< port, 0 = any
    std::uint16_t port = 0;
  };
  [[nodiscard]] Result<Listener> open(const camera_server::CameraServerOptions& options) const;

  protocols::CameraPictures& pictures_;
  const MakeOptions make_options_;
  std::mutex update_mutex_;  // of what follows
  bool stopped_ = false;
  std::shared_ptr<const protocols::CameraList> followed_;
  mutable std::mutex mutex_;  // of the map; only those who hold both change it
  std::map<std::string, Listener> listeners_;
};

}  // namespace aprsim::server
