#pragma once

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

/// A directory of the run's own, gone with it.
class RunDirectory {
 public:
  /// `kept`: where it is and stays; empty = somewhere.
  explicit RunDirectory(const std::string& kept);
  ~RunDirectory();
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;
  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
  bool kept_;
};

/// The end of a log, to be told with a failure.
[[nodiscard]] std::string last_lines(const std::string& file);

/// Those that the scenario lets its controller use, else all of the scene.
[[nodiscard]] std::vector<std::string> robots_of(const scenario::Scenario& scenario,
                                                 const scene::Scene& scene);
/// Who passes virtual time beside the runner: whoever polls and `looks`.
[[nodiscard]] std::vector<std::string> roles_of(const std::vector<std::string>& robots, bool looks);
/// As `--pacers` has them.
[[nodiscard]] std::string pacers_of(const std::vector<std::string>& roles);

struct DaemonOptions {
  std::string pacers;   ///< of virtual time; empty = stepped
  std::string journal;  ///< file or directory; empty = none
};
/// Where the cell of a run is.
struct Place {
  Endpoints endpoints;
  std::string ports_file;                       ///< empty = none
  std::optional<process::ChildProcess> daemon;  ///< absent = somebody else's
};

/// A daemon of the run's own, on free ports, with the planned scene. Failures: it does not start,
/// it does not serve in time.
[[nodiscard]] Outcome<Place> own_place(const scenario::Plan& plan, const RunDirectory& directory,
                                       const DaemonOptions& options);

struct ControllerOptions {
  std::string command;  ///< for the shell; empty = the scenario's own program
  double poll_ms = 25;  ///< of the own program
  bool polls_are_clock = false;
  bool again = false;  ///< the own program takes one job after the other
};
/// What starts the controller.
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

  /// In place of the one that there was, which is killed with all that it has started.
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
