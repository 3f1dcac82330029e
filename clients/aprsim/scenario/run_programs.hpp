#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "clients/wires/endpoints.hpp"
#include "clients/wires/outcome.hpp"
#include "world/base/process/child_process.hpp"
#include "world/scenario/plan.hpp"
#include "world/scenario/scenario.hpp"

/// The programs of a run: its daemon and its controller. Thread: one.
namespace aprsim::client {

/// A temporary directory of one run.
class RunDirectory {
 public:
  /// `kept`: a directory that stays; empty = a temporary one.
  explicit RunDirectory(const std::string& kept);
  ~RunDirectory();
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;
  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }
  /// The files that a run writes into its directory, without the logs of restarted controllers.
  [[nodiscard]] static std::vector<std::string> files(const std::string& directory);

 private:
  std::filesystem::path path_;
  bool kept_;
};

/// The end of a log for the message of a failure: "the end of FILE: ..." or "FILE is empty".
[[nodiscard]] std::string log_end(const std::string& file);

/// The robots that the scenario names for its controller, else all robots of the scene.
[[nodiscard]] std::vector<std::string> robots_of(const scenario::Scenario& scenario,
                                                 const scene::Scene& scene);
/// Roles that advance virtual time beside the runner; `uses_vision` adds the cameras.
[[nodiscard]] std::vector<std::string> roles_of(const scenario::Scenario& scenario,
                                                const std::vector<std::string>& robots,
                                                bool uses_vision);
/// The roles in the syntax of `--pacers`.
[[nodiscard]] std::string pacers_of(const std::vector<std::string>& roles);

struct DaemonOptions {
  std::string pacers;                  ///< of virtual time; empty = stepped
  std::string journal;                 ///< file or directory; empty = none
  std::chrono::seconds patience{600};  ///< until it serves
};
/// The cell of a run.
struct Place {
  Endpoints endpoints;
  std::string ports_file;                       ///< empty = none
  std::optional<process::ChildProcess> daemon;  ///< absent = started elsewhere
};

/// A daemon of the run's own, on free ports, with the planned scene. Failures: it does not start,
/// it does not serve in time.
[[nodiscard]] Outcome<Place> own_place(const scenario::Plan& plan, const RunDirectory& directory,
                                       const DaemonOptions& options);

struct ControllerOptions {
  std::string command;  ///< for the shell; empty = the scenario's own program
  double poll_ms = 25;  ///< of the own program
  bool polls_are_clock = false;
  bool reuse_controller = false;  ///< the program takes one job after the other
};
/// The command line of the controller.
[[nodiscard]] std::vector<std::string> controller_command(const scenario::Scenario& scenario,
                                                          const ControllerOptions& options,
                                                          const Place& place);

/// The controller, which may be killed and started again.
class Controller {
 public:
  /// The directory outlives it.
  Controller(std::vector<std::string> command, std::string ports_file,
             const RunDirectory& directory)
      : command_(std::move(command)), ports_file_(std::move(ports_file)), directory_(directory) {}

  /// Starts a controller and kills the previous one with its child processes.
  Outcome<void> start();
  void kill();
  [[nodiscard]] bool is_there() const { return process_.has_value(); }
  [[nodiscard]] process::ChildProcess& process() { return *process_; }

 private:
  std::vector<std::string> command_;
  std::string ports_file_;
  const RunDirectory& directory_;
  std::optional<process::ChildProcess> process_;
  int starts_ = 0;
};

}  // namespace aprsim::client
