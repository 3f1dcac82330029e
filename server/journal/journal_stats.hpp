#pragma once

#include <cstdint>

namespace aprsim::server::journal {

/// Counts of a journal since its start.
struct JournalStats {
  std::uint64_t records = 0, bytes = 0;  ///< written to files
  std::uint64_t gaps = 0, missing = 0;   ///< gaps, and the records missing in them
  std::uint64_t memory_bytes = 0;        ///< kept in memory
  std::uint64_t queued_bytes = 0;        ///< of records that wait for the writer
};

}  // namespace aprsim::server::journal
