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

/// A job for the cell with what goes wrong in it, as data. Read from YAML by scenario_reader.hpp,
/// made concrete by plan.hpp. SI; times are simulated ones.
namespace aprsim::scenario {

/// Something that happens in a run and that orders may wait for.
struct OnPlaced {
  unsigned count = 1;  ///< so many parts have been put into kits
};
struct OnSubmitted {
  std::string order;
};
struct OnFault {
  std::string fault;  ///< by name: it begins
};
/// A time since the start, or an event.
using Moment = std::variant<double, OnPlaced, OnSubmitted, OnFault>;

/// A place on the floor plan: between two corners [m], in the world.
struct Area {
  std::array<double, 2> min_m{}, max_m{};
};

struct Order {
  std::string name;
  std::string tray;                          ///< type of the kit tray
  std::map<std::string, std::string> slots;  ///< gear type in each slot that is to be filled
  unsigned count = 1;                        ///< kits
  int priority = 0;                          ///< more is more urgent
  std::optional<double> deadline_s;          ///< from its announcement on
  Moment announced = 0.0;
  std::optional<Moment> cancelled;
  std::optional<Area> destination;  ///< where its kits have to be when they are submitted
};

/// An injected fault, as aprsim.v1.InjectFaultRequest has it.
struct Fault {
  std::string name;  ///< empty = none
  std::string kind;
  std::string target;
  std::map<std::string, double> parameters;
  std::optional<std::array<double, 2>> at_s;  ///< begins between these, drawn by the seed
  std::optional<faults::FaultWhen> when;      ///< never with at_s; neither = at the start
  std::optional<double> for_s;                ///< absent = until it is ended
};

/// Variation between seeds: each value is drawn evenly from +- its bound.
struct Variation {
  double tray_xy_m = 0, tray_yaw_rad = 0;
  double gear_yaw_rad = 0;  ///< of gears in their slots
  double friction = 0;      ///< as a share, of all pairs of surfaces together
  double gear_mass = 0;     ///< as a share, of each type
  /// Bounds of a camera's noise, drawn between them [m], [rad]; absent = the scene's.
  std::optional<std::array<double, 2>> vision_position_noise_m, vision_rotation_noise_rad;
};

/// When a run ends. It ends in any case when the controller does.
struct Stop {
  double time_limit_s = 600;
  bool orders_submitted = true;   ///< all, and none is still to be announced
  std::optional<double> quiet_s;  ///< nothing has moved for so long
};

/// The permitted range of a measure.
struct Bound {
  std::optional<double> min, max;
};

/// Weights of the scores; their sources stand in the client's scores.hpp.
struct Scoring {
  double slot = 3, tray = 1, priority = 3;
  double collision = 100, collision_again_s = 5, invalid_surface = 25;
  std::optional<double> baseline_s;      ///< time of the committed run without faults
  std::optional<double> baseline_score;  ///< its completion
};

struct Scenario {
  std::string name, file, description;
  std::string scene_file;           ///< of the scene it is based on
  std::string scene_text;           ///< that scene with what the scenario takes out and puts in
  scene::Scene scene;               ///< the same, read
  bool own_parts = false;           ///< it takes parts out of the scene or puts some in
  std::string cell;                 ///< what the kitting controller calls the cell
  std::string program = "kitting";  ///< its controller, of clients/kitting
  std::vector<std::string> controller_options;
  std::vector<Order> orders;
  std::vector<Fault> faults;
  /// When the controller is killed and started again: each between two times [s], drawn by the
  /// seed.
  std::vector<std::array<double, 2>> kills_s;
  Variation variation;
  Stop stop;
  std::map<std::string, Bound> expected;  ///< by measure
  Scoring scoring;
};

}  // namespace aprsim::scenario
