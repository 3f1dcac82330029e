#pragma once

#include <string>

#include "aprsim/v1/snapshot.pb.h"
#include "clients/aprsim/text/paint.hpp"

namespace aprsim::client {

[[nodiscard]] double seconds(const google::protobuf::Duration& span);

/// A few lines that say how the cell is: time, health, each robot, the belt, the bodies.
[[nodiscard]] std::string status_text(const v1::Snapshot& snapshot, const Paint& paint);
/// One line for each gear and tray.
[[nodiscard]] std::string bodies_text(const v1::Snapshot& snapshot);
/// One line for one sample of a stream.
[[nodiscard]] std::string watch_line(const v1::Snapshot& snapshot, std::uint64_t dropped,
                                     const Paint& paint);
/// Says how many samples of a stream were lost; empty when none was.
[[nodiscard]] std::string dropped_text(std::uint64_t dropped);

}  // namespace aprsim::client
