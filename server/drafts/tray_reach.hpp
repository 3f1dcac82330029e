#pragma once

#include <vector>

#include "protocols/ports/scene_drafts.hpp"
#include "world/api/snapshot/snapshot.hpp"
#include "world/cell/world.hpp"

namespace aprsim::server {

/// The slots of each tray that each robot reaches, as a part in them is gripped: the tool of the
/// start over the slot, along its axis, in any of 24 directions about it, and the same 0.1 m above.
/// Joint limits count, obstacles do not. Arms without inverse kinematics reach nothing. Thread:
/// any.
[[nodiscard]] std::vector<web::SceneDraft::Reach> tray_reaches(const world::ArmModels& models,
                                                               const api::Snapshot& snapshot);

}  // namespace aprsim::server
