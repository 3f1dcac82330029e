#pragma once

#include <memory>

#include "server/config/config.hpp"
#include "server/operations/ports_file.hpp"
#include "server/replay/replay_files.hpp"
#include "world/base/result.hpp"

namespace aprsim::server {

/// Serves a recorded run and its past to browsers and gRPC clients, without commands.
class ReplayDaemon {
 public:
  /// `run` outlives it. Throws std::runtime_error naming the cause.
  ReplayDaemon(const Config& config, const journal::RecordedRun& run, journal::ReplayPart part,
               std::optional<double> speed);
  ~ReplayDaemon();
  ReplayDaemon(const ReplayDaemon&) = delete;
  ReplayDaemon& operator=(const ReplayDaemon&) = delete;

  /// Opens the listeners, then begins the replay. Errors name the listener, address and port.
  [[nodiscard]] Result<Ports> start();
  void stop();
  /// Does nothing: a replay records no journal.
  void finish_journal() {}
  /// As Daemon::reload().
  void reload();
  [[nodiscard]] std::string problem() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::server
