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

/// A submitted kit, or an ordered one that was never submitted.
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
  std::optional<double> recovery_s;  ///< until the next part was placed in a kit
  bool recovered = false;
};

struct RobotResult {
  std::string name;
  unsigned grasps = 0, grasps_failed = 0, grasps_repeated = 0, drops = 0;
  double moving_s = 0, total_s = 0, path_m = 0, energy_j = 0;
  std::vector<std::array<double, 2>> moving;  ///< intervals of motion
};

/// Figures that a controller reports about itself.
struct ControllerWords {
  std::optional<unsigned> replans;
  std::optional<double> crcl_requests, modbus_requests, vision_frames;
};

struct Measured {
  std::map<std::string, double> values;  ///< by scenario::MeasureKind; absent = not measured
  std::vector<KitResult> kits;
  std::vector<Placement> placements;
  std::vector<Collision> collisions;
  std::vector<FaultResult> faults;
  std::vector<RobotResult> robots;
  double end_s = 0;
};

/// Measures a run from its samples. Changes of a gripper shorter than the sampling period are not
/// seen. Throws std::invalid_argument for an unknown order. Thread: one.
class Measures {
 public:
  Measures(CellShape shape, std::vector<scenario::Order> orders);
  ~Measures();

  /// The next sample, later than the last one.
  void add(const Sample& sample);

  /// Announces an order at the time of the latest sample.
  void announced(const std::string& order);
  /// Cancels the kits of an order that are not submitted.
  void cancelled(const std::string& order);
  /// Submits a kit in its present state: the nearest one within 0.15 m of a place, or without a
  /// place the one that fits best. False when all have been submitted.
  bool submitted(const std::string& order, const std::optional<Eigen::Vector2d>& place);

  /// Kits of an order that are not submitted yet.
  [[nodiscard]] unsigned open(const std::string& order) const;
  /// Complete kit trays of an order's type that are not submitted.
  [[nodiscard]] unsigned fulfilled(const std::string& order) const;
  /// Submitted kits of an order.
  [[nodiscard]] unsigned submitted_kits(const std::string& order) const;
  /// Correct parts in an order's kits: the submitted ones, and the fullest trays of its type for
  /// the open ones.
  [[nodiscard]] std::size_t filled(const std::string& order) const;
  [[nodiscard]] std::size_t placed() const;
  /// Time since the last motion [s].
  [[nodiscard]] double quiet_s() const;

  /// The measures without scores, which add_scores() adds (scores.hpp).
  [[nodiscard]] Measured result(const ControllerWords& words) const;

 private:
  struct State;
  /// Whether the body is in a slot or a gripper.
  [[nodiscard]] bool is_somewhere(std::size_t body) const;
  void add_recovery(Measured& out, double first_s) const;
  std::unique_ptr<State> state_;
};

/// Quantile of the values, with linear interpolation.
[[nodiscard]] double quantile(std::vector<double> values, double share);

}  // namespace aprsim::client
