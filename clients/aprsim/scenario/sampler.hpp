#pragma once

#include <array>

#include "aprsim/v1/cell.pb.h"
#include "aprsim/v1/snapshot.pb.h"
#include "clients/aprsim/scenario/sample.hpp"

namespace aprsim::client {

/// Fields of a snapshot that a run reads.
inline constexpr std::array kSampledFields = {
    "epoch",  "step",          "sim_time",        "world_fault",         "robots", "conveyor",
    "bodies", "light_curtain", "injected_faults", "unintended_contacts", "tools",
};

[[nodiscard]] CellShape shape_of(const v1::CellDescription& cell);
[[nodiscard]] Sample sample_of(const v1::Snapshot& snapshot, const v1::CellDescription& cell);

}  // namespace aprsim::client
