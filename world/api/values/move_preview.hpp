#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "world/api/values/planning_mode.hpp"
#include "world/base/time.hpp"

/// A move that was planned without being made. SI; R = the robot's reference frame.
namespace aprsim::api {

/// Points of a preview, at most; their spacing grows for longer moves.
inline constexpr std::size_t kMaxPreviewPoints = 501;
inline constexpr double kPreviewSpacing_s = 0.02;  ///< between the points, at least
inline constexpr double kMaxPreview_s = 300;       ///< duration of a move that is previewed

/// Where a move would touch something.
struct PreviewTouch {
  std::string mover, other;                       ///< the part of the robot, and what it touches
  Eigen::Vector3d p_R = Eigen::Vector3d::Zero();  ///< middle of the mover's shape there [m]
  double time_s = 0;                              ///< after the start of the motion
};

struct PreviewPoint {
  std::vector<double> joints;                      ///< positions [rad, m of prismatic ones]
  Eigen::Vector3d p_RT = Eigen::Vector3d::Zero();  ///< the tool's point [m]
};

struct MovePreview {
  // ---- the cell that it is planned for
  std::uint64_t epoch = 0, step = 0;
  SimTime time{};

  PlanningMode mode = PlanningMode::kDirect;
  std::string refusal;  ///< in the words of the refused move; empty = it can be made
  /// The reason for the refusal. In mode direct a move that can be made may have one, too.
  std::optional<PreviewTouch> touch;
  double delay_s = 0;     ///< from the command to the motion
  double duration_s = 0;  ///< of the motion
  double length_m = 0;    ///< of the way of the tool's point
  double spacing_s = 0;   ///< between the points; shorter before the last one
  /// The motion from its start to its end. If it is blocked, the motion that would touch
  /// something; empty for any other refusal.
  std::vector<PreviewPoint> points;
};

}  // namespace aprsim::api
