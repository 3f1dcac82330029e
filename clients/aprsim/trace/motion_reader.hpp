#pragma once

#include <functional>
#include <string>

#include "aprsim/v1/motion.pb.h"
#include "world/base/result.hpp"

namespace aprsim::trace {

/// Receives one snapshot; `scene`: the new scene at the first snapshot and at changes, else null.
using TakeMotion =
    std::function<void(double time_s, const v1::Snapshot& snapshot, const v1::MotionHeader* scene)>;

/// The snapshots of a motion file with their time since the run's beginning, also over resets.
/// Errors: kNotFound, kUnavailable, kInvalidArgument.
[[nodiscard]] Result<void> read_motion(const std::string& file, const TakeMotion& take);

}  // namespace aprsim::trace
