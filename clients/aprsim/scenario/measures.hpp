#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/aprsim/scenario/sample.hpp"
#include "world/scenario/scenario.hpp"

namespace aprsim::client {

/// A kit as it was submitted, or one that never was.
struct KitResult {
  std::string order;
  std::string tray;  ///< name of the body; empty = never submitted
  int priority = 0;
  double announced_s = 0;
  std::optional<double> submitted_s;
  bool tray_right = false;
  bool at_destination = true;
  bool late = false;
  unsigned ordered = 0;  ///< parts
  unsigned right = 0;    ///< in their slots, upright and good
  unsigned surplus = 0;  ///< in slots for which nothing was ordered

  [[nodiscard]] bool is_right() const {
    return submitted_s && tray_right && at_destination && right == ordered && surplus == 0;
  }
};

/// A part put into a slot of a kit tray.
struct Placement {
  double time_s = 0;
  std::string robot, gear, slot;  ///< slot: "TRAY/SLOT"
  double error_m = 0;             ///< from the slot's centre, in space
  double turned_rad = 0;          ///< against the gripper, from grasp to release
  bool right_type = true;
};

struct Collision {
  std::string pair;
  bool two_robots = false;
  double begin_s = 0, end_s = 0;
  double max_n = 0;
};

struct FaultResult {
  std::string kind, target;
  double begin_s = 0;
  std::optional<double> end_s;
  std::optional<double> recovery_s;  ///< until the next part was put into a kit
  bool recovered = false;
};

struct RobotResult {
  std::string name;
  unsigned grasps = 0, grasps_failed = 0, grasps_repeated = 0, drops = 0;
  double moving_s = 0, total_s = 0, path_m = 0, energy_j = 0;
  std::vector<std::array<double, 2>> moving;  ///< when, from and to
};

/// What a controller says of itself.
struct ControllerWords {
  std::optional<unsigned> replans;
  std::optional<double> crcl_requests, modbus_requests, vision_frames;
};

struct Measured {
  std::map<std::string, double> values;  ///< by scenario::MeasureKind; absent = nothing to tell
  std::vector<KitResult> kits;
  std::vector<Placement> placements;
  std::vector<Collision> collisions;
  std::vector<FaultResult> faults;
  std::vector<RobotResult> robots;
  double end_s = 0;
};

/// Watches a run. Of the grippers it does not see what is shorter than the time between two
/// samples. Throws std::invalid_argument for an order that it does not know. Thread: one.
class Measures {
 public:
  Measures(CellShape shape, std::vector<scenario::Order> orders);
  ~Measures();

  /// The next sample, later than the last one.
  void add(const Sample& sample);

  /// The order's kits are wanted from now on, the time of the latest sample.
  void announced(const std::string& order);
  /// Those that are not submitted are not wanted any more.
  void cancelled(const std::string& order);
  /// A kit is submitted as it now is: that nearest to a place, within 0.15 m, or without one that
  /// which fits best. False when there is none that has not been submitted before.
  bool submitted(const std::string& order, const std::optional<Eigen::Vector2d>& place);

  /// Kits of an order that are still to be submitted.
  [[nodiscard]] unsigned open(const std::string& order) const;
  /// Kit trays of an order's type that hold exactly what it wants and are not submitted.
  [[nodiscard]] unsigned fulfilled(const std::string& order) const;
  /// Kits of an order that were submitted.
  [[nodiscard]] unsigned submitted_kits(const std::string& order) const;
  /// Parts that are right in an order's kits: in those that were submitted, and in the fullest
  /// trays of its type for those that still are to be.
  [[nodiscard]] std::size_t filled(const std::string& order) const;
  [[nodiscard]] std::size_t placed() const;
  /// Time since anything last moved.
  [[nodiscard]] double quiet_s() const;

  /// Without scores; those add theirs (scores.hpp).
  [[nodiscard]] Measured result(const ControllerWords& words) const;

 private:
  struct State;
  /// In a slot or a gripper.
  [[nodiscard]] bool is_somewhere(std::size_t body) const;
  void add_recovery(Measured& out, double first_s) const;
  std::unique_ptr<State> state_;
};

/// The value below which a share of the values lies, between two of them as the median does.
[[nodiscard]] double quantile(std::vector<double> values, double share);

}  // namespace aprsim::client
