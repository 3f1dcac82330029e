#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "crcl/documents.hpp"
#include "crcl/status.hpp"
#include "protocols/crcl/command_submitter.hpp"
#include "protocols/crcl/connection_settings.hpp"
#include "protocols/crcl/guard_book.hpp"
#include "protocols/crcl/program_runner.hpp"
#include "protocols/crcl/robot_parameters.hpp"
#include "protocols/crcl/status_builder.hpp"
#include "protocols/crcl/target_limits.hpp"
#include "protocols/crcl/ticket_book.hpp"
#include "world/api/ports.hpp"

namespace aprsim::protocols {

struct CommandLifecycleOptions {
  int robot = 0;                 ///< index into CellDescription::robots
  api::EndpointId endpoint = 0;  ///< stamped on every command
  bool clamp_targets = false;    ///< else targets beyond the limits are refused
  std::optional<Eigen::Vector3d> cartesian_min_R, cartesian_max_R;  ///< [m]
  std::size_t max_program_bytes = 0;
  std::int64_t start_ms = 0;  ///< simulated time 0 in ms since 1970
};

/// The CRCL side of one robot, shared by all its connections: which command is the latest, how far
/// it has come, whether an error is held, which program runs. The rules are those of CrclServer.
/// Knows no sockets. Thread: the server's.
class CommandLifecycle {
 public:
  CommandLifecycle(CommandLifecycleOptions options, api::CommandSink& sink,
                   const api::SnapshotSource& source);

  /// Executes any command but GetStatus. `settings` are those of its connection.
  void execute(const crcl::CommandInstance& instance,
               const std::shared_ptr<ConnectionSettings>& settings, const std::string& peer);
  /// Executes the commands of a program in order, each once the one before is done, until the end,
  /// an error, or a command of any client that needs the robot.
  void execute(crcl::Program program, const std::shared_ptr<ConnectionSettings>& settings,
               const std::string& peer);
  /// Takes a command that could not be decoded into an error under its own id.
  void refuse(const std::string& type, std::int64_t id, const std::string& reason);
  /// Stops the robot and holds an error, under the id of the last command.
  void bad_document(const std::string& reason);

  /// Goes on with the program that runs. To be called again and again while runs_program().
  void advance();
  [[nodiscard]] bool runs_program() const { return program_.has_value(); }
  /// `wake` is called when a program begins to run.
  void on_program(std::function<void()> wake) { wake_ = std::move(wake); }

  /// The answer to one GetStatus. Every call gives a new StatusID.
  [[nodiscard]] crcl::Status status(const ConnectionSettings& settings);

  /// "crcl.fanuc", for log lines.
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  enum class Session { kNever, kOpen, kEnded };  // InitCanon .. EndCanon
  enum class Progress { kReady, kDone, kWaiting };
  struct Executor;
  friend struct Executor;

  void carry_out(const crcl::CommandInstance& instance,
                 const std::shared_ptr<ConnectionSettings>& settings, const std::string& peer);
  void begin(const std::string& type, const crcl::CommandInstance& instance);
  [[nodiscard]] bool admits(const crcl::CommandBody& body);
  void done(std::optional<std::string> description = std::nullopt);
  /// Follows the ticket. A setting is done once applied, whatever the robot does besides.
  void wait_for(const Result<api::Ticket>& ticket, bool setting);
  /// Done with the ticket: whatever comes next finds it applied.
  void done_with(const Result<api::Ticket>& ticket);
  [[nodiscard]] bool taken(const Result<api::Ticket>& ticket, bool setting);
  /// Shows the note with the command that is under way.
  void append_note(const std::optional<std::string>& note);
  void add_description(const std::string& text);
  void latch_error(std::string reason);
  void refresh(const api::Snapshot& snapshot);
  void begin_epoch(const api::Snapshot& snapshot);
  void begin_anew(bool interrupted);
  void go_on(const api::RobotSnapshot& robot, bool interrupted);
  void follow(const api::Snapshot& snapshot);
  [[nodiscard]] crcl::CommandStatus command_status();
  void run_text(const crcl::RunProgram& command,
                const std::shared_ptr<ConnectionSettings>& settings, const std::string& peer);
  void start(ProgramRunner run);
  [[nodiscard]] bool step_done(const api::Snapshot& snapshot);
  [[nodiscard]] const api::RobotDescription& description() const {
    return cell_->robots[static_cast<std::size_t>(robot_)];
  }

  CommandLifecycleOptions options_;
  int robot_;
  const api::SnapshotSource& source_;
  CommandSubmitter commander_;
  std::shared_ptr<const api::CellDescription> cell_;
  RobotParameters services_;
  CartesianLimits limits_;
  GuardBook guards_;
  std::string name_;
  std::uint64_t epoch_ = 0;

  Session session_ = Session::kNever;
  crcl::CommandStatus latest_;  // ids, name and program position of the latest command
  Progress progress_ = Progress::kReady;
  api::Ticket ticket_ = 0;  // while kWaiting
  bool setting_ = false;
  api::Ticket since_ = 0;         // the world's errors before this command are over
  api::Ticket last_setting_ = 0;  // the latest one that changes no motion
  api::Ticket seen_ = 0;          // the world has applied all up to this one
  TicketBook tickets_;
  std::optional<std::string> error_;  // held until InitCanon
  Tolerances tolerances_;
  std::optional<ProgramRunner> program_;
  bool in_program_ = false;  // the latest command is the program's
  std::function<void()> wake_;
};

}  // namespace aprsim::protocols
