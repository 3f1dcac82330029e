#pragma once

#include <optional>
#include <vector>

#include "aprsim/v1/web.pb.h"
#include "world/api/ports/move_previews.hpp"
#include "world/api/ports/ports.hpp"

namespace aprsim::web {

/// Commands for the world that a viewer's request stands for, in order of submission. Absent for
/// other requests (watch, authenticate, jog, write_register). Errors name field, value and limit.
[[nodiscard]] std::optional<Result<std::vector<decltype(api::Command::body)>>> commands_of(
    const v1::ViewerRequest& request, const api::Snapshot& snapshot);

/// The move of a robot's request, as its robot would make it. Errors name field, value and limit.
[[nodiscard]] Result<api::PreviewRequest> preview_of(const v1::RobotRequest& request,
                                                     const api::Snapshot& snapshot);

/// Whether the request is a stop: of a robot, the belt, the whole cell, or of simulated time.
[[nodiscard]] bool is_stop(const v1::ViewerRequest& request);

}  // namespace aprsim::web
