#pragma once

#include <optional>
#include <string>

#include "world/api/commands/command.hpp"
#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::test {

/// A slot of a tray, by the names of the scene.
struct SlotName {
  std::string tray, slot;
};

/// One robot carries one gear to and fro between two slots, as the APRS controllers do: open,
/// above, down, close, up, over, down, open, up. Never waits: it says what to send next.
class Shuttle {
 public:
  /// Throws std::runtime_error for a name that the cell does not have.
  Shuttle(const api::CellDescription& cell, int robot, const std::string& gear, SlotName from,
          SlotName to);

  /// The action to send now that the last one is done; nullopt after the last of a trip. Targets
  /// come from where gear and slot are in `now`.
  std::optional<api::RobotAction> next(const api::Snapshot& now);
  /// Ends a trip: the next one goes back. Throws std::runtime_error when the gear is not in its
  /// slot.
  void finish_trip(const api::Snapshot& now);

  [[nodiscard]] int robot() const { return robot_; }
  [[nodiscard]] int trips() const { return trips_; }
  /// The fingers are closing on the gear, closed or opening.
  [[nodiscard]] bool gripping() const { return stage_ > 6 && stage_ < 17; }

 private:
  struct Place {
    std::size_t tray = 0;
    Eigen::Isometry3d X_PS;
  };
  static Place find(const api::CellDescription& cell, const SlotName& name);
  [[nodiscard]] Eigen::Isometry3d X_WG(const api::Snapshot& now) const;
  [[nodiscard]] Eigen::Isometry3d X_WS(const api::Snapshot& now) const;
  [[nodiscard]] api::MoveTo move(const Eigen::Vector3d& p_WT, bool straight) const;

  int robot_;
  std::size_t gear_ = 0;
  Place from_, to_;
  Eigen::Isometry3d X_RW_;
  double grip_z_ = 0;
  int stage_ = 0, trips_ = 0;
  Eigen::Vector3d p_W_ = Eigen::Vector3d::Zero();  // of the tool when gripping, then when placing
};

}  // namespace aprsim::test
