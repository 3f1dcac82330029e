#pragma once

#include <chrono>
#include <csignal>
#include <cstdint>
#include <optional>

#include "world/base/result.hpp"

/// Settings of the process, before any thread starts.
namespace aprsim::server {

/// Raises the limit of open files to the hard limit. Fails when even that is below `needed`.
[[nodiscard]] Result<void> raise_file_limit(std::uint64_t needed);

/// Makes threads share pools of memory. One for each, the default, keeps the most that its thread
/// ever had at once, so that a daemon of many threads grows for hours.
void share_memory_pools();

/// Blocks SIGTERM, SIGINT and SIGHUP for this and all later threads and ignores SIGPIPE.
void block_signals();

/// Waits for one of the blocked signals, for so long at most; its number, if one came.
[[nodiscard]] std::optional<int> wait_for_signal(std::optional<std::chrono::milliseconds> limit);

/// Whether a terminal controls this process, whose SIGHUP then says that it closes.
[[nodiscard]] bool has_terminal();

/// From now on a signal ends the process at once, for a second SIGTERM while stopping.
void unblock_signals();

}  // namespace aprsim::server
