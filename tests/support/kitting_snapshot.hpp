#pragma once

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::test {

/// A cell in the middle of something, in step 100: a robot of two joints that holds a gear, a tray
/// with a slot, a belt with a photo-eye, a light curtain; and as many more gears.
[[nodiscard]] api::SnapshotPtr kitting_snapshot(int more_gears = 0);

}  // namespace aprsim::test
