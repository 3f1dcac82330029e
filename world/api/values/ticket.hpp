#pragma once

#include <cstdint>

namespace aprsim::api {

/// Number of an accepted command, rising by one in the order in which commands take effect.
/// 0 = none.
using Ticket = std::uint64_t;

}  // namespace aprsim::api
