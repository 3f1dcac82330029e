#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/scenario/run_result.hpp"
#include "clients/wires/endpoints.hpp"
#include "clients/wires/outcome.hpp"
#include "world/scenario/plan.hpp"
#include "world/scenario/scenario.hpp"

namespace aprsim::client {

/// A cell that runs already.
struct RunningCell {
  Endpoints endpoints;
  std::string ports_file;  ///< for the controller; empty = it knows where the cell is
};

/// How far a run is.
struct OrderProgress {
  std::string name, tray;
  std::string state;  ///< "waits" for its announcement, "open", "done" or "cancelled"
  unsigned kits = 0, submitted = 0;
  std::size_t parts = 0, parts_wanted = 0;  ///< right in its kits
};
struct RunProgress {
  double time_s = 0;
  std::size_t placed = 0;  ///< parts put into kits, whether right or not
  std::vector<OrderProgress> orders;
};

/// Who is told of a run while it goes on.
struct RunListener {
  std::function<void(const RunEvent&)> event = [](const RunEvent&) {};
  /// Twice a second of wall time at most, and at the end; empty = nobody is told.
  std::function<void(const RunProgress&)> progress;
};

struct RunOptions {
  std::optional<RunningCell> cell;  ///< absent = a daemon of its own
  std::optional<double> speed = 1;  ///< of simulated time; absent = as fast as possible
  /// In place of the speed: simulated time passes as the controller polls, and the same seed gives
  /// the same result to the bit. A controller in place of the kitting one polls every robot.
  bool virtual_time = false;
  /// A command for the shell in place of the kitting controller, "none" to wait for one that
  /// somebody else starts; empty = the kitting controller.
  std::string controller;
  std::string
      directory;        ///< keeps the scene, the logs and what the controller says; empty = nothing
  std::string journal;  ///< file or directory for that of an own daemon; empty = none
};

/// Runs a planned scenario: starts a daemon of its own on free ports with the planned scene, and
/// the controller; injects the faults, announces orders, watches by gRPC, until a stop condition
/// holds, and stops both. What happens is told as it does.
///
/// A cell that runs already is reset with the seed and runs on afterwards, without what is left of
/// the faults. It keeps its own scene: what varies in the planned one does not vary there, and a
/// scenario with parts of its own is refused.
///
/// The controller finds the ports in the file that APRSIM_PORTS_FILE names. Orders come on its
/// standard input, one JSON object a line, {"announce": NAME, "tray": TYPE, "count": N, "priority":
/// N, "slots": {SLOT: TYPE}} and {"cancel": NAME}; it answers on standard output, {"event":
/// "submit", "order": NAME, "x_m": X, "y_m": Y}, with the place of the tray in the world where it
/// knows that. "replan": true in any line counts as a change of plan, and "crcl_requests",
/// "modbus_requests", "vision_frames" are taken from the last line that has them. Of a controller
/// that says nothing a kit counts as submitted when it is as ordered. One that is killed and
/// started again (kill_controller) is told all orders that still hold once more, in full; a tray
/// that it submits a second time counts once.
///
/// Failures: what cannot be started, a cell of another scene, a daemon that dies, an interruption.
[[nodiscard]] Outcome<RunResult> run_scenario(const scenario::Scenario& scenario,
                                              const scenario::Plan& plan, const RunOptions& options,
                                              const RunListener& listener);

}  // namespace aprsim::client
