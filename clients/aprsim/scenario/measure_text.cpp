#include "clients/aprsim/scenario/measure_text.hpp"

#include <fmt/format.h>

#include "clients/aprsim/scenario/report_page.hpp"
#include "world/scenario/measure_kinds.hpp"

namespace aprsim::client {

std::string measure_unit(const std::string& measure) {
  const auto* kind = scenario::find_measure(measure);
  return kind == nullptr || kind->unit == "1" ? "" : std::string(kind->unit);
}

int better_side(const std::string& measure) {
  if (measure == kAsExpected) return 1;
  const auto* kind = scenario::find_measure(measure);
  return kind == nullptr ? 0 : kind->better;
}

std::string better_text(const std::string& measure) {
  const int side = better_side(measure);
  return side > 0 ? "higher" : side < 0 ? "lower" : "";
}

std::string measure_title(const std::string& measure) {
  const std::string unit = measure_unit(measure);
  return unit.empty() ? measure : fmt::format("{} [{}]", measure, unit);
}

std::string measure_value_alone(const std::string& measure, double value) {
  const std::string unit = measure_unit(measure);
  return figure_text(value) + (unit.empty() ? "" : ' ' + unit);
}

std::string measure_value(const std::string& measure, double value) {
  return measure + ' ' + measure_value_alone(measure, value);
}

}  // namespace aprsim::client
