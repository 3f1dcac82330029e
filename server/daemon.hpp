#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/config/config.hpp"
#include "server/operations/ports_file.hpp"
#include "world/base/result.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server {

/// The daemon: one simulation with all its listeners.
class Daemon {
 public:
  /// Builds the world. `demo`: start() also starts the kitting controller. Throws
  /// std::runtime_error with the cause when the scene cannot be built or the run not be recorded.
  Daemon(const Config& config, std::shared_ptr<const scene::Scene> scene, bool demo = false);
  ~Daemon();
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  /// Builds everything as the constructor does, but writes no file. Throws as it does.
  static void check(Config config, std::shared_ptr<const scene::Scene> scene);

  /// Opens all listeners, then starts the simulation. After an error the destructor closes what is
  /// open. Errors name listener, address and port.
  [[nodiscard]] Result<Ports> start();

  /// Calls `take` with all ports where another scene has others, before the client of the reset
  /// gets its answer. Thread of the call: the daemon's own, until stop(). Thread: the owner's.
  void on_ports(std::function<void(const Ports&)> take);

  /// Stops accepting, lets replies go out, stops the simulation and finishes the journal; well
  /// under two seconds.
  void stop();
  /// Finishes the journal alone, where stop() takes too long. Thread: any.
  void finish_journal();

  /// Reads tokens and certificates again and reopens the audit file. A file that cannot be read is
  /// logged, and its earlier content stays in force.
  void reload();

  /// Whether the simulation thread makes progress, also while paused or in a fault.
  [[nodiscard]] bool makes_progress() const;
  /// Reason why the simulation does not run at the requested pace; empty = none.
  [[nodiscard]] std::string problem() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Maximum of open files of a daemon of this scene under the configured connection limits, with a
/// reserve.
[[nodiscard]] std::uint64_t needed_files(const Config& config, const scene::Scene& scene);

}  // namespace aprsim::server
