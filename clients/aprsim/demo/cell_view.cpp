#include "clients/aprsim/demo/cell_view.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "clients/aprsim/demo/geometry.hpp"

namespace aprsim::client {
namespace {

// A gear this close to a slot counts as in it; slots are at least 50 mm apart.
constexpr double kInSlot_m = 0.01;
// No gear's centre may be this close to a slot that is to be filled.
constexpr double kOccupied_m = 0.02;
// Distance from the base at which arms of this size work best.
constexpr double kHandy_m = 0.5;

// Places beyond this need a large arm.
constexpr double kFar_m = 0.75;

double distance(const Eigen::Vector3d& p_WB, const Eigen::Isometry3d& X) {
  return (X.translation() - p_WB).head<2>().norm();
}

/// The farther of the two places from a base.
double reach(const Eigen::Vector3d& p_WB, const Transfer& transfer) {
  return std::max(distance(p_WB, transfer.gear.X_WP), distance(p_WB, transfer.to.X_WS));
}

/// Deviation of the worse of the two places from the best distance.
double unhandiness(const Eigen::Vector3d& p_WB, const Transfer& transfer) {
  return std::max(std::abs(distance(p_WB, transfer.gear.X_WP) - kHandy_m),
                  std::abs(distance(p_WB, transfer.to.X_WS) - kHandy_m));
}

}  // namespace

bool over_belt(const v1::ConveyorDescription& belt, const Eigen::Vector3d& p_W) {
  const Eigen::Vector3d p_C = isometry(belt.belt_in_world()).inverse() * p_W;
  return std::abs(p_C.x()) < belt.length_m() / 2 && std::abs(p_C.y()) < belt.width_m() / 2;
}

CellView::CellView(const v1::CellDescription& cell, const v1::Snapshot& snapshot) {
  const int count = std::min(cell.bodies_size(), snapshot.bodies_size());
  for (int i = 0; i < count; ++i) {
    const auto& body = cell.bodies(i);
    if (!body.has_gear()) continue;
    gears_.push_back({body.name(), body.type(), body.gear(),
                      isometry(snapshot.bodies(i).body_in_world()), snapshot.bodies(i).resting()});
  }
  for (int i = 0; i < count; ++i) {
    const auto& body = cell.bodies(i);
    const Eigen::Isometry3d X_WP = isometry(snapshot.bodies(i).body_in_world());
    const bool on_belt = cell.has_conveyor() && over_belt(cell.conveyor(), X_WP.translation());
    for (const auto& slot : body.tray().slots()) {
      SlotView view{body.name(), slot.name(), slot.gear_type(),
                    body.kind(), on_belt,     X_WP * isometry(slot.slot_in_tray()),
                    ""};
      for (const auto& gear : gears_) {
        const double distance = (gear.X_WP.translation() - view.X_WS.translation()).norm();
        const bool fits = gear.type == view.gear_type && distance < kInSlot_m;
        if (fits || distance < kOccupied_m) view.gear = gear.name;
      }
      slots_.push_back(std::move(view));
    }
  }
}

const GearView* CellView::gear(const std::string& name) const {
  const auto found = std::ranges::find(gears_, name, &GearView::name);
  return found == gears_.end() ? nullptr : &*found;
}

const SlotView* CellView::slot(const std::string& tray, const std::string& slot) const {
  const auto found = std::ranges::find_if(
      slots_, [&](const SlotView& view) { return view.tray == tray && view.slot == slot; });
  return found == slots_.end() ? nullptr : &*found;
}

bool CellView::has_gear_in_part_tray() const {
  return std::ranges::any_of(slots_, [](const SlotView& slot) {
    return slot.tray_kind == v1::BODY_KIND_PART_TRAY && !slot.gear.empty();
  });
}

std::vector<Transfer> CellView::transfers(const Eigen::Vector3d& p_WB, bool on_belt,
                                          const std::string& preferred_tray) const {
  std::vector<Transfer> out;
  for (const auto& from : slots_) {
    const GearView* taken = gear(from.gear);
    if (from.tray_kind != v1::BODY_KIND_PART_TRAY || taken == nullptr || !taken->resting) continue;
    for (const auto& to : slots_) {
      if (to.tray_kind == v1::BODY_KIND_KIT_TRAY && to.gear.empty() &&
          to.gear_type == taken->type) {
        out.push_back({*taken, from, to});
      }
    }
  }
  std::ranges::stable_sort(out, {}, [&](const Transfer& transfer) {
    const int elsewhere = static_cast<int>(transfer.from.on_belt != on_belt) +
                          static_cast<int>(transfer.to.on_belt != on_belt);
    return std::tuple(reach(p_WB, transfer) > kFar_m, transfer.from.tray != preferred_tray,
                      elsewhere, unhandiness(p_WB, transfer));
  });
  return out;
}

}  // namespace aprsim::client
