#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "aprsim/v1/cell.pb.h"
#include "aprsim/v1/snapshot.pb.h"

namespace aprsim::client {

/// A slot of a tray in its present pose.
struct SlotView {
  std::string tray;
  std::string slot;
  std::string gear_type;
  v1::BodyKind tray_kind = v1::BODY_KIND_UNSPECIFIED;
  bool on_belt = false;
  Eigen::Isometry3d X_WS;
  std::string gear;  ///< name of the gear in it; empty = free

  [[nodiscard]] std::string name() const { return tray + "/" + slot; }
};

/// A gear in its present pose.
struct GearView {
  std::string name;
  std::string type;
  v1::GearGeometry geometry;
  Eigen::Isometry3d X_WP;
  bool resting = false;
};

/// A gear in a part tray and a free slot of a kit tray that takes it.
struct Transfer {
  GearView gear;
  SlotView from, to;
};

/// Gears, slots and trays, from the description of the cell and one snapshot.
class CellView {
 public:
  CellView(const v1::CellDescription& cell, const v1::Snapshot& snapshot);

  [[nodiscard]] const std::vector<SlotView>& slots() const { return slots_; }
  [[nodiscard]] const std::vector<GearView>& gears() const { return gears_; }
  [[nodiscard]] const GearView* gear(const std::string& name) const;
  [[nodiscard]] const SlotView* slot(const std::string& tray, const std::string& slot) const;

  /// Whether a gear is left in a part tray.
  [[nodiscard]] bool has_gear_in_part_tray() const;

  /// Every possible transfer, best first: not too far from a robot whose base stands at p_WB, then
  /// gears of `preferred_tray`, then both trays on the belt or both beside it as `on_belt` says,
  /// then the shortest reach.
  [[nodiscard]] std::vector<Transfer> transfers(const Eigen::Vector3d& p_WB, bool on_belt,
                                                const std::string& preferred_tray) const;

 private:
  std::vector<GearView> gears_;
  std::vector<SlotView> slots_;
};

/// True when a point lies over the belt.
[[nodiscard]] bool over_belt(const v1::ConveyorDescription& belt, const Eigen::Vector3d& p_W);

}  // namespace aprsim::client
