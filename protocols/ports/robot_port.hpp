#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "crcl/documents.hpp"
#include "crcl/error.hpp"
#include "crcl/status.hpp"
#include "crcl/units.hpp"
#include "world/base/result.hpp"

/// A robot by the rules of its CRCL port, for wires that carry values and no documents: what
/// listeners other than the port's own need of it.
namespace aprsim::protocols {

/// The client at the end of a session. Thread: the robot's; nothing here may wait.
class RobotClient {
 public:
  virtual ~RobotClient() = default;
  /// The latest message has been taken; the next may come.
  virtual void on_taken() = 0;
  /// A status: the answer to a GetStatus, or one of those that report_every() asks for.
  virtual void on_status(const crcl::Status& status) = 0;
  /// The command of execute() is over, or another client's has come before.
  virtual void on_over(const crcl::Status& status, bool replaced) = 0;
  /// The robot's side has ended the session: kInvalidArgument for the client's fault, else
  /// kUnavailable. The last call, unless the client closes first.
  virtual void on_end(const Error& reason) = 0;
};

/// One session, as a connection to the CRCL port is one. It ends by close(), or by itself.
/// Thread: any.
class RobotSession {
 public:
  virtual ~RobotSession() = default;
  /// A command, or why it could not be read; the next only after on_taken().
  virtual void send(crcl::Result<crcl::CommandInstance> command) = 0;
  virtual void send(crcl::Result<crcl::Program> program) = 0;
  /// As send(), and tells once when the command is over.
  virtual void execute(crcl::Result<crcl::CommandInstance> command) = 0;
  /// Statuses from now on, until the end.
  virtual void report_every(std::chrono::nanoseconds period) = 0;
  virtual void close() = 0;
};

struct RobotSessionOptions {
  std::string peer;  ///< address and port
  // Absent = as for a new connection.
  std::optional<crcl::LengthUnit> length;
  std::optional<crcl::AngleUnit> angle;
  std::optional<crcl::ForceUnit> force;
  std::optional<crcl::TorqueUnit> torque;
  std::optional<crcl::ConfigureStatusReport> report;
};

/// A robot's port. Thread: any, between its start and its stop.
class RobotPort {
 public:
  virtual ~RobotPort() = default;
  /// The robot's name in the scene.
  [[nodiscard]] virtual const std::string& robot() const = 0;
  /// Opens a session; the client is told nothing before this returns. Fails with kUnavailable when
  /// there are too many, or the port is closed.
  [[nodiscard]] virtual Result<std::shared_ptr<RobotSession>> open(
      RobotSessionOptions options, std::shared_ptr<RobotClient> client) = 0;
};

}  // namespace aprsim::protocols
