#pragma once

#include <cstdint>

#include "server/config/config.hpp"
#include "world/base/result.hpp"

namespace aprsim::server {

/// The parts of memory.max_mb, each an upper limit [bytes]. A part that the configuration sets by
/// a key of its own has that size.
struct MemoryShares {
  std::uint64_t total = 0;
  std::uint64_t program = 0;        ///< code, the worlds of the cell and of its past
  std::uint64_t journal_ring = 0;   ///< latest part of the run, for incidents
  std::uint64_t journal_queue = 0;  ///< records that wait to be written, of either kind
  std::uint64_t journal_files = 0;  ///< frames that wait for a slow reader of the journal
  std::uint64_t history = 0;
  std::uint64_t past_states = 0;  ///< computed for queries of the past
  std::uint64_t saved_states = 0;
  std::uint64_t clients = 0;                   ///< all of what follows
  std::uint64_t grpc = 0;                      ///< buffers of gRPC
  std::uint64_t backlogs = 0;                  ///< samples that wait for slow readers of streams
  std::uint64_t answers = 0;                   ///< messages of gRPC that wait for slow readers
  std::uint64_t transfers = 0;                 ///< saved states on their way in and out
  std::uint64_t pages = 0;                     ///< messages that wait for slow pages
  std::uint64_t documents = 0;                 ///< unfinished documents of CRCL, of all robots
  std::uint64_t crcl_tap = 0, modbus_tap = 0;  ///< documents and requests that pages show
};

/// Error: memory.max_mb has no room for the program, the clients and what other keys ask for.
[[nodiscard]] Result<MemoryShares> memory_shares(const Config& config);

}  // namespace aprsim::server
