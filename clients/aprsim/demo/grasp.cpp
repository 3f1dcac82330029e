#include "clients/aprsim/demo/grasp.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "clients/aprsim/demo/geometry.hpp"

namespace aprsim::client {
namespace {

constexpr double kTipOverDisc_m = 0.004;
constexpr int kYaws = 24;
// Outline of one finger seen from above, generous for both grippers: across and along its travel.
constexpr double kFingerHalfWidth_m = 0.02;
constexpr double kFingerDepth_m = 0.058;
// More clearance than this is no better.
constexpr double kEnough_m = 0.01;
// Differences in clearance below this do not outweigh turning.
constexpr double kSame_m = 0.001;

/// Signed distance of a point to a rectangle centred at the origin.
double distance_to_box(double x, double y, double half_x, double half_y) {
  const double dx = std::abs(x) - half_x, dy = std::abs(y) - half_y;
  return std::hypot(std::max(dx, 0.0), std::max(dy, 0.0)) + std::min(std::max(dx, dy), 0.0);
}

}  // namespace

double grasp_height_m(const v1::GearGeometry& gear) {
  return gear.disc_height_m() + kTipOverDisc_m;
}

double finger_clearance_m(const CellView& view, const std::string& ignored,
                          const v1::GripperDescription& gripper, const Eigen::Vector3d& p_WT,
                          double yaw_rad) {
  const Eigen::Isometry3d X_TW = tool_down(p_WT, yaw_rad).inverse();
  const double centre = gripper.gap_open_m() / 2 + kFingerDepth_m / 2;
  double clearance = kEnough_m;
  for (const auto& gear : view.gears()) {
    if (gear.name == ignored) continue;
    const Eigen::Vector3d p_T =
        X_TW * (gear.X_WP * Eigen::Vector3d(0, 0, gear.geometry.peg_top_m()));
    // z of the tool points down: a peg below the finger tips lies at positive z.
    if (p_T.z() > 0) continue;
    const double distance = distance_to_box(p_T.x(), std::abs(p_T.y()) - centre, kFingerHalfWidth_m,
                                            kFingerDepth_m / 2);
    clearance = std::min(clearance, distance - gear.geometry.peg_radius_m());
  }
  return clearance;
}

std::vector<double> rank_yaws(const CellView& view, const Transfer& transfer,
                              const v1::GripperDescription& gripper, double present_yaw_rad) {
  const Eigen::Vector3d up(0, 0, grasp_height_m(transfer.gear.geometry));
  const Eigen::Vector3d p_pick = transfer.gear.X_WP.translation() + up;
  const Eigen::Vector3d p_place = transfer.to.X_WS.translation() + up;
  std::vector<std::tuple<double, double, double>> ranked;
  for (int i = 0; i < kYaws; ++i) {
    const double yaw = wrapped(present_yaw_rad + 2 * std::numbers::pi * i / kYaws);
    const double clearance =
        std::min(finger_clearance_m(view, transfer.gear.name, gripper, p_pick, yaw),
                 finger_clearance_m(view, transfer.gear.name, gripper, p_place, yaw));
    ranked.emplace_back(-std::floor(clearance / kSame_m), std::abs(wrapped(yaw - present_yaw_rad)),
                        yaw);
  }
  std::ranges::sort(ranked);
  std::vector<double> yaws;
  for (const auto& entry : ranked) yaws.push_back(std::get<2>(entry));
  return yaws;
}

}  // namespace aprsim::client
