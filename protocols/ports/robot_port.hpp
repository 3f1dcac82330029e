#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "crcl/documents.hpp"
#include "crcl/error.hpp"
#include "crcl/status.hpp"
#include "crcl/units.hpp"
#include "world/base/result.hpp"

/// A robot with the rules of its CRCL port, for wires that carry values instead of documents.
namespace aprsim::protocols {

/// The client of a session. Thread: the robot's; no call may block.
class RobotClient {
 public:
  virtual ~RobotClient() = default;
  /// The latest message was accepted; the next may follow.
  virtual void on_taken() = 0;
  /// A status: the answer to a GetStatus, or one by report_every().
  virtual void on_status(const crcl::Status& status) = 0;
  /// The command of execute() has ended, or another client's has replaced it.
  virtual void on_over(const crcl::Status& status, bool replaced) = 0;
  /// The robot's side has ended the session: kInvalidArgument for an error of the client, else
  /// kUnavailable. This is the last call, unless the client closes first.
  virtual void on_end(const Error& reason) = 0;
};

/// A session, as a connection to the CRCL port is one. It ends by close() or on the robot's side.
/// Thread: any.
class RobotSession {
 public:
  virtual ~RobotSession() = default;
  /// Sends a command, or the reason why it could not be read; the next only after on_taken().
  virtual void send(crcl::Result<crcl::CommandInstance> command) = 0;
  virtual void send(crcl::Result<crcl::Program> program) = 0;
  /// As send(); also reports the end of the command, once.
  virtual void execute(crcl::Result<crcl::CommandInstance> command) = 0;
  /// Reports statuses from now on until the end.
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

/// The port of a robot. Thread: any, between start and stop.
class RobotPort {
 public:
  virtual ~RobotPort() = default;
  /// The robot's name in the scene.
  [[nodiscard]] virtual const std::string& robot() const = 0;
  /// Opens a session; the client is not called before this returns. Errors: kUnavailable when there
  /// are too many sessions, or the port is closed.
  [[nodiscard]] virtual Result<std::shared_ptr<RobotSession>> open(
      RobotSessionOptions options, std::shared_ptr<RobotClient> client) = 0;
};

/// The ports of the present robots, which change with the scene. Thread: any.
class RobotPorts {
 public:
  virtual ~RobotPorts() = default;
  /// Null = the cell has no robot of this name. The port lasts as long as it is kept.
  [[nodiscard]] virtual std::shared_ptr<RobotPort> find(const std::string& robot) const = 0;
  [[nodiscard]] virtual std::vector<std::string> names() const = 0;
};

}  // namespace aprsim::protocols
