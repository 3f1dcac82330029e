#pragma once

#include <memory>
#include <string>
#include <string_view>

#include <boost/asio/io_context.hpp>

#include "crcl/framer.hpp"
#include "protocols/crcl/command_executor.hpp"
#include "protocols/crcl/crcl_session.hpp"
#include "world/base/result.hpp"

namespace aprsim::embedded {

/// A robot's CRCL port without its socket. Thread: that of the cell.
class EmbeddedRobot {
 public:
  /// `sink` and `source` outlive it.
  EmbeddedRobot(int robot, api::CommandSink& sink, const api::SnapshotSource& source);
  ~EmbeddedRobot();
  EmbeddedRobot(const EmbeddedRobot&) = delete;
  EmbeddedRobot& operator=(const EmbeddedRobot&) = delete;

  /// Takes bytes of the client: parts of documents, or several. Errors: the connection has ended;
  /// the text says why.
  [[nodiscard]] Result<void> send(std::string_view bytes);
  /// The statuses since the last call. Waits for them while an injected fault delays one.
  [[nodiscard]] std::string take_statuses();
  /// Begins a new connection in place of the present one.
  void reconnect();
  /// Continues a program, and returns whether it runs. To be called after each step.
  bool advance() {
    if (executor_.runs_program()) executor_.advance();
    return executor_.runs_program();
  }

 private:
  class Wire;

  crcl_server::CrclServerOptions options_;
  boost::asio::io_context io_;
  crcl_server::CommandExecutor executor_;
  crcl_server::CrclCounters counters_;
  std::shared_ptr<Wire> wire_;
};

}  // namespace aprsim::embedded
