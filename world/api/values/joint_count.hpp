#pragma once

namespace aprsim::api {

inline constexpr int kMaxJoints = 7;  ///< of a robot

}  // namespace aprsim::api
