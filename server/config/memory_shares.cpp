#include "server/config/memory_shares.hpp"

#include <fmt/format.h>

namespace aprsim::server {
namespace {

constexpr std::uint64_t kMb = std::uint64_t{1} << 20U;
/// Memory of a default cell with its past, before anything is kept and anyone connects.
constexpr std::uint64_t kProgram = 72 * kMb;
/// A queue is emptied by a swap, so there are two of each: of decisions and of what only informs.
constexpr std::uint64_t kQueues = 4;

std::uint64_t percent(std::uint64_t of, std::uint64_t parts) { return of / 100 * parts; }

std::uint64_t or_share(const std::optional<std::uint32_t>& set_mb, std::uint64_t share) {
  return set_mb ? *set_mb * kMb : share;
}

}  // namespace

Result<MemoryShares> memory_shares(const Config& config) {
  MemoryShares shares;
  shares.total = config.memory.max_mb * kMb;
  shares.program = kProgram;
  shares.clients = percent(shares.total, 26);
  shares.grpc = percent(shares.clients, 26);
  shares.backlogs = percent(shares.clients, 18);
  shares.answers = percent(shares.clients, 8);
  shares.transfers = percent(shares.clients, 16);
  shares.pages = percent(shares.clients, 8);
  shares.documents = percent(shares.clients, 8);
  shares.crcl_tap = percent(shares.clients, 8);
  shares.modbus_tap = percent(shares.clients, 2);
  const std::uint64_t rest = shares.total - shares.program - shares.clients;
  shares.journal_ring = or_share(config.journal.memory_mb, percent(rest, 34));
  shares.journal_queue = percent(rest, 16) / kQueues;
  shares.journal_files = percent(rest, 4);
  shares.history = or_share(config.history.max_mb, percent(rest, 26));
  shares.past_states = percent(rest, 8);
  shares.saved_states = or_share(config.memory.saved_states_mb, percent(rest, 12));
  const std::uint64_t needed = shares.program + shares.clients + shares.journal_ring +
                               kQueues * shares.journal_queue + shares.journal_files +
                               shares.history + shares.past_states + shares.saved_states;
  if (needed <= shares.total) return shares;
  return fail(ErrorCode::kInvalidArgument, "memory.max_mb",
              fmt::format("memory.max_mb: {} MB are too few: journal.memory_mb {}, history.max_mb "
                          "{}, memory.saved_states_mb {} and all else together need {} MB",
                          config.memory.max_mb, shares.journal_ring / kMb, shares.history / kMb,
                          shares.saved_states / kMb, (needed + kMb - 1) / kMb));
}

}  // namespace aprsim::server
