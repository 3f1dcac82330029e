#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/text/paint.hpp"
#include "clients/wires/conveyor_state.hpp"

namespace aprsim::client {

/// A few lines.
[[nodiscard]] std::string conveyor_text(const ConveyorState& state, const Paint& paint);

[[nodiscard]] nlohmann::ordered_json conveyor_json(const ConveyorState& state);

/// The cause that keeps the belt from running; empty = none.
[[nodiscard]] std::string conveyor_problem(const ConveyorState& state);

}  // namespace aprsim::client
