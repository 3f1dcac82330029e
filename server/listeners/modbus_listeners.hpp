#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "protocols/modbus/modbus_server.hpp"
#include "world/api/ports/ports.hpp"
#include "world/base/result.hpp"

namespace aprsim::server {

/// The Modbus servers that the present scene describes, by name. Where another scene is loaded,
/// they open and close; a server of the same name stays, with the new map.
class ModbusListeners {
 public:
  /// Options of the server with this name at this place in the scene.
  using MakeOptions =
      std::function<modbus_server::ModbusServerOptions(std::size_t place, const std::string& name)>;

  /// Sink and source outlive it.
  ModbusListeners(api::CommandSink& sink, const api::SnapshotSource& source,
                  MakeOptions make_options);
  ~ModbusListeners();
  ModbusListeners(const ModbusListeners&) = delete;
  ModbusListeners& operator=(const ModbusListeners&) = delete;

  /// Opens those of the present scene. Error: that of the first that cannot listen; its field is
  /// the server's name. Once only.
  [[nodiscard]] Result<void> start();
  /// Follows the present scene. A server that cannot listen is logged. Thread: one.
  void update();
  /// Closes all, and every later update() does nothing. Thread: the owner's.
  void stop();

  /// Thread: any.
  [[nodiscard]] std::map<std::string, std::uint16_t> ports() const;
  [[nodiscard]] std::map<std::string, modbus_server::ModbusServerStats> stats() const;

 private:
  struct Listener {
    std::unique_ptr<modbus_server::ModbusServer> server;
    std::uint16_t port = 0;
  };
  [[nodiscard]] Result<void> open_missing(bool ends_on_error);
  void close_gone();

  api::CommandSink& sink_;
  const api::SnapshotSource& source_;
  const MakeOptions make_options_;
  std::mutex update_mutex_;  // of what follows
  bool stopped_ = false;
  std::shared_ptr<const api::CellDescription> followed_;
  mutable std::mutex mutex_;  // of the map; only those who hold both change it
  std::map<std::string, Listener> listeners_;
};

}  // namespace aprsim::server
