#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "crcl/documents.hpp"
#include "crcl/status.hpp"
#include "protocols/crcl/command_lifecycle.hpp"
#include "protocols/crcl/command_submitter.hpp"
#include "protocols/crcl/connection_settings.hpp"
#include "protocols/crcl/joint_map.hpp"
#include "protocols/crcl/program_runner.hpp"
#include "protocols/crcl/robot_parameters.hpp"
#include "protocols/crcl/si_conversion.hpp"
#include "protocols/net/limited_log.hpp"
#include "world/api/ports/ports.hpp"
#include "world/base/rate_limit.hpp"

namespace aprsim::crcl_server {

struct CommandExecutorOptions {
  int robot = 0;                      ///< index into CellDescription::robots
  api::EndpointId endpoint = 0;       ///< stamped on every command
  std::optional<bool> clamp_targets;  ///< as in CrclServerOptions
  std::optional<Eigen::Vector3d> cartesian_min_R, cartesian_max_R;  ///< [m]
  std::size_t max_program_bytes = 0;
  bool end_program_with_client = false;  ///< else it continues
  std::int64_t start_ms = 0;             ///< simulated time 0 in ms since 1970
  bool virtual_time = false;  ///< limits programs to a number of commands a simulated second
  protocols::RefusalSink* refusals = nullptr;  ///< see CommandLifecycle
};

/// Effects of injected faults on a CRCL port. Times are wall-clock.
struct PortFaults {
  bool half_document = false;  ///< a status is cut in the middle, and the connection closes
  bool old_status = false;     ///< statuses are of the previous command
  std::chrono::nanoseconds late_status{};  ///< delay of a status
  std::chrono::nanoseconds slow{};         ///< delay before each document is processed
};

/// Executes the commands and programs of all clients of one robot, and builds its statuses. The
/// CommandLifecycle decides which commands are admitted and tracks the latest one. Independent of
/// sockets. Thread: the server's.
class CommandExecutor {
 public:
  CommandExecutor(CommandExecutorOptions options, api::CommandSink& sink,
                  const api::SnapshotSource& source);

  /// Executes any command but GetStatus.
  void execute(const crcl::CommandInstance& instance, const Caller& caller);
  /// Executes the commands of a program in order, each after the previous one is done, until the
  /// end, an error, or a command of any client that needs the robot.
  void execute(crcl::Program program, const Caller& caller);
  /// Reports a command that could not be decoded as an error under its own id.
  void refuse(std::string_view type, std::int64_t id, const std::string& reason);
  /// Stops the robot and latches an error, under the id of the last command.
  void bad_document(const std::string& reason);
  /// The same for the connection of the latest command to the robot, if it did not close but was
  /// reset or broken; nothing for others.
  void client_lost(const Caller& caller, const std::string& reason);

  /// Continues the running program. To be called periodically while runs_program().
  void advance();
  [[nodiscard]] bool runs_program() const { return program_.has_value(); }
  /// A client has disconnected. Its motion continues; its program too, unless configured.
  void client_gone(const Caller& caller);
  /// `wake` is called when a program begins to run.
  void on_program(std::function<void()> wake) { wake_ = std::move(wake); }

  /// The answer to one GetStatus. Every call gives a new StatusID.
  [[nodiscard]] crcl::Status status(const ConnectionSettings& settings);

  /// Number of commands of clients so far, without polls and commands of programs.
  [[nodiscard]] std::uint64_t commands() const { return commands_; }
  /// Whether the latest command is done or in error.
  [[nodiscard]] bool over();

  /// Present effects of injected faults on the port.
  [[nodiscard]] PortFaults faults() const;

  /// Whether this is the first status that reports the end of the latest command: done or in error.
  /// To be called once for each status.
  [[nodiscard]] bool first_to_tell_end(crcl::CommandState state);

  /// The robot has this index in the source's latest snapshot, of another scene.
  void set_robot(int robot);

  /// The robot's name in the scene.
  [[nodiscard]] const std::string& robot() const { return description().name; }
  /// Log of the peers' actions, under the name "crcl.fanuc".
  [[nodiscard]] protocols::LimitedLog& log() { return log_; }
  [[nodiscard]] const std::string& name() const { return log_.name(); }

 private:
  struct Visitor;
  friend struct Visitor;

  void carry_out(const crcl::CommandInstance& instance, const Caller& caller);
  void keep_old_status();
  void stop_robot();
  [[nodiscard]] bool follows_stream() const;
  void start(ProgramRunner program);
  [[nodiscard]] bool step_done(const api::Snapshot& snapshot);
  void observe(const api::Snapshot& snapshot);
  /// Reads the robot's conventions again if the scene has changed.
  void follow_scene(const api::Snapshot& snapshot);
  [[nodiscard]] RobotParameters parameters_of(const api::CellDescription& cell) const;
  [[nodiscard]] bool clamps_targets() const {
    return options_.clamp_targets.value_or(description().clamps_targets);
  }
  [[nodiscard]] bool program_runs() const { return program_ && in_program_; }
  [[nodiscard]] const api::RobotDescription& description() const {
    return cell_->robots[static_cast<std::size_t>(options_.robot)];
  }

  CommandExecutorOptions options_;
  const api::SnapshotSource& source_;
  std::shared_ptr<const api::CellDescription> cell_;
  JointMap joints_;
  protocols::LimitedLog log_;
  CommandLifecycle lifecycle_;
  CommandSubmitter submitter_;
  RobotParameters parameters_;
  CartesianLimits limits_;
  Tolerances tolerances_;
  GuardedCommand guarded_;
  std::optional<ProgramRunner> program_;
  protocols::RateLimit program_pace_;
  bool in_program_ = false;                     // the latest command belongs to program_
  std::optional<crcl::CommandState> end_told_;  // of the latest command
  std::string commander_;                       // peer that sent the robot's latest command
  /// State of the previous command, while an injected fault reports that instead.
  std::optional<crcl::CommandStatus> old_status_;
  std::function<void()> wake_;
  std::uint64_t commands_ = 0;
};

}  // namespace aprsim::crcl_server
