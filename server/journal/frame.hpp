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
  Missing held;             ///< what is missing where it is lost
  bool begins = false;      ///< with the whole state: a replay can begin with it
  std::uint64_t clock = 0;  ///< steps at its first record, those of all epochs added up
};

}  // namespace aprsim::server::journal
