#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "crcl/documents.hpp"
#include "crcl/status.hpp"
#include "protocols/crcl/curtain_sensor.hpp"
#include "protocols/crcl/report_settings.hpp"
#include "protocols/crcl/robot_commander.hpp"
#include "world/api/ports.hpp"

namespace aprsim::protocols {

/// The CRCL side of one robot, shared by all its connections: which command is the latest, how far
/// it has come, whether an error is held. The rules are those of CrclServer. Knows no sockets.
/// Thread: the server's.
class RobotLink {
 public:
  /// Tolerances that clients have set, lengths in m, angles in rad (joints too).
  struct Tolerances {
    std::optional<crcl::PoseTolerance> end, intermediate;
    std::vector<crcl::JointTolerance> joints;
  };

  RobotLink(int robot, api::EndpointId endpoint, api::CommandSink& sink,
            const api::SnapshotSource& source);

  /// Executes any command but GetStatus. `settings` are those of its connection.
  void execute(const crcl::CommandInstance& instance, ReportSettings& settings,
               const std::string& peer);
  /// Takes a command that could not be decoded into an error under its own id.
  void refuse(const std::string& type, std::int64_t id, const std::string& reason);
  /// Stops the robot and holds an error, under the id of the last command.
  void bad_document(const std::string& reason);

  /// The answer to one GetStatus. Every call gives a new StatusID.
  [[nodiscard]] crcl::Status status(const ReportSettings& settings);

  /// "crcl.fanuc", for log lines.
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  enum class Session { kNever, kOpen, kEnded };  // InitCanon .. EndCanon
  enum class Progress { kReady, kDone, kWaiting };
  struct Executor;
  friend struct Executor;

  void begin(const std::string& type, const crcl::CommandInstance& instance);
  [[nodiscard]] bool admits(const crcl::CommandBody& body);
  void done(std::optional<std::string> description = std::nullopt);
  /// Follows the ticket. A setting is done once applied, whatever the robot does besides.
  void wait_for(const Result<api::Ticket>& ticket, bool setting);
  void hold(std::string reason);
  void refresh(const api::Snapshot& snapshot);
  void follow(const api::Snapshot& snapshot);
  [[nodiscard]] crcl::CommandStatus command_status();

  int robot_;
  const api::SnapshotSource& source_;
  RobotCommander commander_;
  std::string name_;
  std::uint64_t epoch_ = 0;

  Session session_ = Session::kNever;
  crcl::CommandStatus latest_;  // ids, name and program position of the latest command
  Progress progress_ = Progress::kReady;
  api::Ticket ticket_ = 0;  // while kWaiting
  bool setting_ = false;
  api::Ticket since_ = 0;             // the world's errors before this command are over
  std::optional<std::string> error_;  // held until InitCanon
  Tolerances tolerances_;
  CurtainSensor curtain_;
};

}  // namespace aprsim::protocols
