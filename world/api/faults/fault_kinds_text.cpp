#include "world/api/faults/fault_kinds_text.hpp"

#include <cstdio>

#include "world/api/faults/fault_kinds.hpp"

namespace aprsim::faults {

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

std::string markdown() {
  std::string out =
      "# Injected faults\n\n"
      "`aprsim fault kinds --markdown` prints this table. `aprsim fault inject KIND [TARGET]` "
      "injects a fault, over gRPC `InjectFault` does. Numbers are SI. A momentary fault ends at "
      "once, and its effect remains. Every other one lasts for its duration, or until it is "
      "ended.\n\n"
      "| kind | target | parameters (default, range) | what happens |\n|---|---|---|---|\n";
  for (const KindInfo& kind : all_kinds()) {
    out += "| `" + std::string(kind.name) + "` | " + std::string(pattern_of(kind.target)) + " | ";
    for (std::size_t i = 0; i < kind.parameter_count(); ++i) {
      const Parameter& parameter = kind.parameters[i];
      const std::string unit = parameter.unit == "1" ? "" : " " + std::string(parameter.unit);
      out += (i == 0 ? "`" : "; `") + std::string(parameter.name) +
             "`: " + std::string(parameter.meaning) + " (" + number_text(parameter.fallback) +
             unit + ", " + number_text(parameter.min) + " to " + number_text(parameter.max) + ")";
    }
    out += " | " + std::string(kind.meaning) + (kind.momentary ? " (momentary)" : "") + " |\n";
  }
  out +=
      "\nA fault can wait for a quantity to cross a limit:\n\n| quantity | unit | meaning "
      "|\n|---|---|---|\n";
  for (const QuantityInfo& quantity : all_quantities()) {
    out += "| `" + std::string(quantity.name) + "` | " + std::string(quantity.unit) + " | " +
           std::string(quantity.meaning) + (quantity.of_robot ? ", of a robot" : "") + " |\n";
  }
  return out;
}

}  // namespace aprsim::faults
