#pragma once

#include <string>

/// Texts about the measures of scenario::measure_kinds(), for reports.
namespace aprsim::client {

/// Name of success among the outcomes of a run, beside the measures.
inline constexpr const char* kAsExpected = "as_expected";

/// "mm"; empty for a measure without a unit.
[[nodiscard]] std::string measure_unit(const std::string& measure);
/// 1 = higher is better, -1 = lower is better, 0 = neither. "as_expected" is better when higher.
[[nodiscard]] int better_side(const std::string& measure);
/// "higher", "lower", or empty.
[[nodiscard]] std::string better_text(const std::string& measure);
/// "job_s [s]"; without a unit "drops".
[[nodiscard]] std::string measure_title(const std::string& measure);
/// "57.1 s".
[[nodiscard]] std::string measure_value_alone(const std::string& measure, double value);
/// "job_s 57.1 s".
[[nodiscard]] std::string measure_value(const std::string& measure, double value);

}  // namespace aprsim::client
