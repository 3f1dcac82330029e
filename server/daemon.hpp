#pragma once

#include <memory>
#include <string>

#include "server/config/config.hpp"
#include "server/operations/ports_file.hpp"
#include "world/base/result.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server {

/// The running product: one simulation and every listener on it. The only place that names them
/// all.
class Daemon {
 public:
  /// Builds the world. `demo`: start() also starts the kitting controller. Throws
  /// std::runtime_error naming the cause when the scene cannot be built.
  Daemon(const Config& config, std::shared_ptr<const scene::Scene> scene, bool demo = false);
  ~Daemon();
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  /// Opens every listener, then sets the simulation going. On failure what was opened is closed by
  /// the destructor. Errors name the listener, address and port.
  [[nodiscard]] Result<Ports> start();

  /// Stops accepting, lets replies go out, stops the simulation; well under two seconds.
  void stop();

  /// Reads tokens and certificates again, and begins the audit's file anew. What cannot be read is
  /// told in the log and stays as it was.
  void reload();

  /// Whether the simulation's thread goes on, be the cell paused or in a fault.
  [[nodiscard]] bool makes_progress() const;
  /// Reason why the simulation does not run as it is told to; empty = none.
  [[nodiscard]] std::string problem() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Open files that the configured connection limits may need at once, with room to spare.
[[nodiscard]] std::uint64_t needed_files(const Config& config, std::size_t robots);

}  // namespace aprsim::server
