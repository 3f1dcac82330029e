#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

namespace aprsim::api {

/// How a robot's moves regard what stands around it.
enum class PlanningMode {
  kDirect,  ///< not at all
  kCheck,   ///< a move that would touch something is refused before it starts
  kAvoid,   ///< the same, and free moves go round
};
/// For checks of states (world/archive).
[[nodiscard]] constexpr PlanningMode last_of(PlanningMode) { return PlanningMode::kAvoid; }

/// Their words in scenes and CRCL, in their order.
inline constexpr std::array<std::string_view, 3> kPlanningModes{"direct", "check", "avoid"};
[[nodiscard]] constexpr std::string_view name_of(PlanningMode mode) {
  return kPlanningModes[static_cast<std::size_t>(mode)];
}
/// None for another word.
[[nodiscard]] constexpr std::optional<PlanningMode> planning_mode_of(std::string_view word) {
  const auto* found = std::ranges::find(kPlanningModes, word);
  if (found == kPlanningModes.end()) return std::nullopt;
  return static_cast<PlanningMode>(found - kPlanningModes.begin());
}

}  // namespace aprsim::api
