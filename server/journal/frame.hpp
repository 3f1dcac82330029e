#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "server/journal/record_queue.hpp"

namespace aprsim::server::journal {

using FrameBytes = std::shared_ptr<const std::string>;

/// Whole records as bytes of a journal file.
struct Frame {
  FrameBytes bytes;
  std::uint64_t records = 0;
  Missing held;             ///< the gap that its loss makes
  bool begins = false;      ///< begins with a checkpoint, where a replay can begin
  std::uint64_t clock = 0;  ///< steps of all epochs before its first record
};

}  // namespace aprsim::server::journal
