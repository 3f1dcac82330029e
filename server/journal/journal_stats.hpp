#pragma once

#include <cstdint>

namespace aprsim::server::journal {

/// What a journal has done so far.
struct JournalStats {
  std::uint64_t records = 0, bytes = 0;  ///< written to files
  std::uint64_t gaps = 0, missing = 0;   ///< gaps told, and the records that they lack
  std::uint64_t memory_bytes = 0;        ///< of the latest, kept in memory
};

}  // namespace aprsim::server::journal
