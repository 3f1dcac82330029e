#pragma once

#include "aprsim/v1/cell.pb.h"
#include "aprsim/v1/snapshot.pb.h"
#include "clients/aprsim/scenario/sample.hpp"

namespace aprsim::client {

[[nodiscard]] CellShape shape_of(const v1::CellDescription& cell);
[[nodiscard]] Sample sample_of(const v1::Snapshot& snapshot, const v1::CellDescription& cell);

}  // namespace aprsim::client
