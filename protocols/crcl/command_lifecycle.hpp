#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "crcl/documents.hpp"
#include "crcl/status.hpp"
#include "protocols/crcl/command_history.hpp"
#include "protocols/crcl/joint_map.hpp"
#include "protocols/net/limited_log.hpp"
#include "protocols/ports/refusal_sink.hpp"
#include "world/api/commands/robot_command.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/base/result.hpp"

namespace aprsim::crcl_server {

/// The state machine of one robot's CRCL port: the session, the latest command with its ticket and
/// state, the error that is held until InitCanon. The rules are those of CrclServer. Submits no
/// commands itself. Thread: the server's.
class CommandLifecycle {
 public:
  /// State of a submission.
  enum class Outcome {
    kPending,
    kDone,
    kBesideSetting,  ///< hidden by a setting in the robot's report; it continues
    kReplaced,       ///< by a command from another interface
  };

  /// `log` and `joints`, by which the robot's messages are explained, outlive this; `robot` indexes
  /// Snapshot::robots; `epoch` is the snapshot's. `refusals` is notified of refused commands; it
  /// outlives this, null = nobody is.
  CommandLifecycle(protocols::LimitedLog& log, const JointMap& joints, int robot,
                   std::uint64_t epoch, protocols::RefusalSink* refusals = nullptr);

  // Requests of clients.

  /// A new latest command. `type` is its type in the schema, by crcl::type_name().
  void begin(std::string_view type, const crcl::CommandInstance& instance);
  /// The same of a document that is no command; `type` is anything.
  void begin_refused(std::string_view type, const crcl::CommandInstance& instance);
  /// Whether session and error allow the command; outside a session an error is latched.
  [[nodiscard]] bool admits(const crcl::CommandBody& body);
  void clear_error();
  void open_session(api::Ticket ticket);

  // Their outcome.

  /// The latest command is under way as `action`; `at_once`: it is done as soon as the robot has
  /// it. A refused ticket is an error: false. The description and the log name a motion that ends
  /// before its target because of it.
  bool submitted(const api::RobotAction& action, const Result<api::Ticket>& ticket, bool at_once);
  void done(std::optional<std::string> description = std::nullopt);
  /// Adds the note, if any, to the description of the present command.
  void append_note(const std::optional<std::string>& note);
  /// The command is refused.
  void latch_error(std::string reason);
  /// An error that no command has caused.
  void fail(std::string reason) { latch(std::move(reason)); }

  /// The robot has this index from now on.
  void set_robot(int robot) { robot_ = robot; }
  /// Updates the state from the world. True if the cell was reset or a saved state was loaded since
  /// the last call.
  [[nodiscard]] bool observe(const api::Snapshot& snapshot);

  [[nodiscard]] Outcome outcome_of(const Submission& command, const api::Snapshot& snapshot) const;
  /// The submission that the latest command waits for.
  [[nodiscard]] std::optional<Submission> pending() const;
  /// Since the first InitCanon; EndCanon leaves it open, as on NIST's servers.
  [[nodiscard]] bool session_open() const { return session_open_; }
  [[nodiscard]] bool in_error() const { return error_.has_value(); }
  /// The latest command's type in the schema.
  [[nodiscard]] std::string_view type() const { return type_; }
  [[nodiscard]] std::int64_t command_id() const { return latest_.command_id; }

  /// State of the latest command. `program_runs` as below.
  [[nodiscard]] crcl::CommandState state(bool program_runs) const;
  /// With a new StatusID. `program_runs`: the latest command is one of a program that goes on.
  [[nodiscard]] crcl::CommandStatus next_status(bool program_runs);

 private:
  enum class Progress { kReady, kDone, kWaiting };

  void begin_epoch(const api::Snapshot& snapshot);
  /// The latest command as the history keeps it.
  [[nodiscard]] CommandHistory::Entry entry() const;
  void after_reset(bool interrupted);
  void after_load(const api::RobotSnapshot& robot, bool interrupted);
  void update_progress(const api::Snapshot& snapshot);
  void describe(const std::string& text);
  void latch(std::string reason);
  [[nodiscard]] const api::RobotSnapshot& robot_in(const api::Snapshot& snapshot) const {
    return snapshot.robots[static_cast<std::size_t>(robot_)];
  }

  protocols::LimitedLog& log_;
  protocols::RefusalSink* const refusals_;
  const JointMap& joints_;
  int robot_;
  std::uint64_t epoch_;

  bool session_open_ = false;
  crcl::CommandStatus latest_;  // ids, name and program position of the latest command
  std::string refused_type_;
  std::string_view type_ = "no command";  ///< a constant, or refused_type_
  Progress progress_ = Progress::kReady;
  Submission submission_;             // while kWaiting
  std::optional<std::string> error_;  // held until InitCanon
  api::Ticket initialized_at_ = 0;    // earlier errors of the world are cleared
  api::Ticket last_setting_ = 0;      // the latest command that changes no motion
  api::Ticket applied_ = 0;           // the world has applied all commands up to this one
  CommandHistory history_;
  std::optional<CommandHistory::Entry> motion_;  // that continues beside later commands
};

}  // namespace aprsim::crcl_server
