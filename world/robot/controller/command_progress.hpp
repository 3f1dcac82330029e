#pragma once

#include <string>

#include "world/api/commands/robot_command.hpp"
#include "world/api/snapshot/robot_snapshot.hpp"

namespace aprsim::robot {

/// Completes the running command.
enum class Task { kNone, kRest, kGripper, kDwell, kToolChanger };
/// For checks of states (world/archive).
[[nodiscard]] constexpr Task last_of(Task) { return Task::kToolChanger; }

/// Progress of the latest command, and the error that is held until the robot is initialized. A
/// copyable value; does not allocate except for long errors. Thread: sim.
class CommandProgress {
 public:
  CommandProgress();

  /// The latest command from now on.
  void accept(api::Ticket ticket, api::ActionKind kind);
  /// The command works until `task` is done. A held error stays.
  void begin(Task task);
  /// The command has no task yet; the one before it continues.
  void wait();
  /// Done, unless an error is held. `description` replaces the one that was set.
  void complete(const char* description = nullptr);
  /// Description of the running command once it is done.
  void set_description(const std::string& description);

  /// Ends the robot's initialization, and holds the error.
  void set_error(const std::string& reason);
  /// Clears the error.
  void initialize();

  [[nodiscard]] const api::ActionStatus& status() const { return status_; }
  [[nodiscard]] Task task() const { return task_; }
  [[nodiscard]] bool in_error() const { return !held_error_.empty(); }
  [[nodiscard]] bool initialized() const { return initialized_; }

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [status, task, held_error, description, initialized] = self;
    io(status, task, held_error, description, initialized);
  }

 private:
  api::ActionStatus status_;
  Task task_ = Task::kNone;
  std::string held_error_;   ///< empty = none
  std::string description_;  ///< of the running command once it is done
  bool initialized_ = false;
};

}  // namespace aprsim::robot
