#pragma once

#include <chrono>
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

/// Wall time without progress after which a run in virtual time is given up, by default. Nothing
/// else in such a run depends on the wall clock.
inline constexpr std::chrono::seconds kPatience{600};

/// A running cell.
struct RunningCell {
  Endpoints endpoints;
  std::string ports_file;  ///< for the controller; empty = it knows the cell's ports
};

/// Progress of one order.
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

/// Receives reports of a run in progress.
struct RunListener {
  std::function<void(const RunEvent&)> event = [](const RunEvent&) {};
  /// Twice a second of wall time at most, and at the end; empty = not reported.
  std::function<void(const RunProgress&)> progress;
};

struct RunOptions {
  std::optional<RunningCell> cell;  ///< absent = a daemon of its own
  std::optional<double> speed = 1;  ///< of simulated time; absent = as fast as possible
  /// Virtual time in place of the speed: the controller's polls advance simulated time, and equal
  /// seeds give bit-identical results. A controller of the user polls every robot.
  bool virtual_time = false;
  /// Shell command of the controller; "none" = wait for one that is started elsewhere; empty =
  /// the kitting controller.
  std::string controller;
  std::string directory;  ///< for the scene, the logs and the controller's output; empty = none
  std::string journal;    ///< file or directory for that of an own daemon; empty = none
  std::chrono::seconds patience = kPatience;  ///< for programs to start, answer or poll
};

/// Runs a planned scenario: starts a daemon of its own on free ports with the planned scene, and
/// the controller; injects the faults, announces orders, watches by gRPC, until a stop condition
/// holds; and stops both. Events are reported as they happen.
///
/// A running cell is reset with the seed and keeps running afterwards; remaining faults are
/// ended. It keeps its own scene without the planned variations, and a scenario with parts of its
/// own is refused.
///
/// The controller finds the ports in the file that APRSIM_PORTS_FILE names. Orders come on its
/// standard input, one JSON object a line, {"announce": NAME, "tray": TYPE, "count": N, "priority":
/// N, "slots": {SLOT: TYPE}} and {"cancel": NAME}; it answers on standard output, {"event":
/// "submit", "order": NAME, "x_m": X, "y_m": Y}, with the place of the tray in the world where it
/// knows that. "replan": true in any line counts as a change of plan, and "crcl_requests",
/// "modbus_requests", "vision_frames" are taken from the last line that has them. If the
/// controller reports nothing, a kit counts as submitted once it is as ordered. A controller that
/// was killed and restarted (kill_controller) receives all open orders again, in full; a tray
/// submitted twice counts once.
///
/// Failures: a program that cannot be started, a cell of another scene, a daemon that dies, an
/// interruption.
[[nodiscard]] Outcome<RunResult> run_scenario(const scenario::Scenario& scenario,
                                              const scenario::Plan& plan, const RunOptions& options,
                                              const RunListener& listener);

}  // namespace aprsim::client
