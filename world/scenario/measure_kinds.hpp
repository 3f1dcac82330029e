#pragma once

#include <span>
#include <string_view>

namespace aprsim::scenario {

/// One measure of a run.
struct MeasureKind {
  std::string_view name, unit;  ///< unit "1" = none
  std::string_view meaning;
  int better = 0;  ///< 1 = higher is better, -1 = lower is better, 0 = neither
};

/// All measures, in the order of reports.
[[nodiscard]] std::span<const MeasureKind> measure_kinds();
/// Null when none has this name.
[[nodiscard]] const MeasureKind* find_measure(std::string_view name);

}  // namespace aprsim::scenario
