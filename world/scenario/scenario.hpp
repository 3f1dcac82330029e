#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "world/api/faults/fault_when.hpp"
#include "world/scene/model/scene.hpp"

/// A job for the cell with its injected faults, as data. scenario_reader.hpp reads it from YAML;
/// plan.hpp draws one run of it. SI units; times are simulated times.
namespace aprsim::scenario {

/// Events of a run that orders may wait for.
struct OnPlaced {
  unsigned count = 1;  ///< parts placed in kits
};
struct OnSubmitted {
  std::string order;
};
struct OnFault {
  std::string fault;  ///< name of the fault that begins
};
/// A time since the start, or an event.
using Moment = std::variant<double, OnPlaced, OnSubmitted, OnFault>;

/// A rectangle on the floor between two corners, in the world [m].
struct Area {
  std::array<double, 2> min_m{}, max_m{};
};

struct Order {
  std::string name;
  std::string tray;                          ///< type of the kit tray
  std::map<std::string, std::string> slots;  ///< slot to gear type
  unsigned count = 1;                        ///< kits
  int priority = 0;                          ///< higher is more urgent
  std::optional<double> deadline_s;          ///< since its announcement
  Moment announced = 0.0;
  std::optional<Moment> cancelled;
  std::optional<Area> destination;  ///< region of its kits at submission
};

/// An injected fault; fields as in aprsim.v1.InjectFaultRequest.
struct Fault {
  std::string name;  ///< empty = none
  std::string kind;
  std::string target;
  std::map<std::string, double> parameters;
  std::optional<std::array<double, 2>> at_s;  ///< range of its begin, drawn by the seed
  std::optional<faults::FaultWhen> when;      ///< trigger; neither this nor at_s = at the start
  std::optional<double> for_s;                ///< absent = until it is ended
};

/// Variation between seeds: each value is drawn uniformly from +- its bound.
struct Variation {
  double tray_xy_m = 0, tray_yaw_rad = 0;
  double gear_yaw_rad = 0;  ///< of gears in their slots
  double friction = 0;      ///< relative, common to all pairs of surfaces
  double gear_mass = 0;     ///< relative, for each type
  /// Ranges of the cameras' noise [m], [rad]; absent = the scene's noise.
  std::optional<std::array<double, 2>> vision_position_noise_m, vision_rotation_noise_rad;
};

/// Conditions that end a run. The end of the controller always ends it.
struct Stop {
  double time_limit_s = 600;
  bool orders_submitted = true;   ///< all orders are announced and submitted
  std::optional<double> quiet_s;  ///< nothing has moved for this time
};

/// The permitted range of a measure.
struct Bound {
  std::optional<double> min, max;
};

/// Weights of the scores; sources: clients/aprsim/scenario/scores.hpp.
struct Scoring {
  double slot = 3, tray = 1, priority = 3;
  double collision = 100, collision_again_s = 5, invalid_surface = 25;
  std::optional<double> baseline_s;      ///< job_s of the reference run without faults
  std::optional<double> baseline_score;  ///< completion score of that run
};

struct Scenario {
  std::string name, file, description;
  std::string scene_file;           ///< file of the underlying scene
  std::string scene_text;           ///< that scene with removed and supplied parts
  scene::Scene scene;               ///< read from scene_text
  bool changes_parts = false;       ///< it removes or supplies parts
  std::string cell;                 ///< name of the cell in clients/kitting/cells
  std::string program = "kitting";  ///< default controller, in clients/kitting
  std::vector<std::string> controller_options;
  std::vector<Order> orders;
  std::vector<Fault> faults;
  /// Ranges of the times at which the controller is killed and restarted, drawn by the seed [s].
  std::vector<std::array<double, 2>> kills_s;
  Variation variation;
  Stop stop;
  std::map<std::string, Bound> expected;  ///< by measure
  Scoring scoring;
};

}  // namespace aprsim::scenario
