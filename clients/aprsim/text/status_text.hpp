#pragma once

#include <string>

#include "aprsim/v1/cell.pb.h"
#include "aprsim/v1/snapshot.pb.h"
#include "clients/aprsim/text/paint.hpp"

namespace aprsim::client {

[[nodiscard]] double seconds(const google::protobuf::Duration& span);

/// The state of the cell in several lines: time, health, robots, belt, bodies. `cell` tells which
/// joints slide.
[[nodiscard]] std::string status_text(const v1::Snapshot& snapshot, const v1::CellDescription& cell,
                                      const Paint& paint);
/// One line for each gear and tray.
[[nodiscard]] std::string bodies_text(const v1::Snapshot& snapshot);
/// One line for one sample of a stream.
[[nodiscard]] std::string watch_line(const v1::Snapshot& snapshot, std::uint64_t dropped,
                                     const Paint& paint);
/// Number of lost samples of a stream, in words; empty for none.
[[nodiscard]] std::string dropped_text(std::uint64_t dropped);

}  // namespace aprsim::client
