#pragma once

#include <functional>
#include <string>

#include "aprsim/v1/motion.pb.h"
#include "world/base/result.hpp"

namespace aprsim::trace {

/// One snapshot; `scene`: what moves from it on, where that is something else, at the first one,
/// too; else null.
using TakeMotion =
    std::function<void(double time_s, const v1::Snapshot& snapshot, const v1::MotionHeader* scene)>;

/// The snapshots of a motion file with their time since the run's beginning, also over resets.
/// Errors: kNotFound, kUnavailable, kInvalidArgument.
[[nodiscard]] Result<void> read_motion(const std::string& file, const TakeMotion& take);

}  // namespace aprsim::trace
