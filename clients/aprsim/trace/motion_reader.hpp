#pragma once

#include <functional>
#include <string>

#include "aprsim/v1/motion.pb.h"
#include "world/api/error.hpp"

namespace aprsim::trace {

/// The snapshots of a motion file with their time since the run's beginning, also over resets.
/// Errors: kNotFound, kUnavailable, kInvalidArgument.
[[nodiscard]] Result<v1::MotionHeader> read_motion(
    const std::string& file, const std::function<void(double time_s, const v1::Snapshot&)>& take);

}  // namespace aprsim::trace
