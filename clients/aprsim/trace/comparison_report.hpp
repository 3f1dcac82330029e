#pragma once

#include <cstddef>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/trace/comparison.hpp"

namespace aprsim::trace {

/// Text for a terminal: the first deviation, the `most` worst ones, and the wires.
[[nodiscard]] std::string report_text(const Comparison& comparison, std::size_t most);
/// The whole comparison.
[[nodiscard]] nlohmann::ordered_json report_json(const Comparison& comparison, const Trace& a,
                                                 const Trace& b, const Tolerance& tolerance);

}  // namespace aprsim::trace
