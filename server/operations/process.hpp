#pragma once

#include <chrono>
#include <csignal>
#include <cstdint>
#include <optional>

#include "world/base/result.hpp"

/// Settings of the process, before any thread starts.
namespace aprsim::server {

/// Opens /dev/null in place of each standard descriptor (0, 1, 2) that is closed, so that no file
/// or socket gets its number and, with it, lines of the log.
void open_standard_descriptors();

/// Raises the limit of open files to the hard limit. Fails where that is below `needed`.
[[nodiscard]] Result<void> raise_file_limit(std::uint64_t needed);

/// Makes threads share pools of memory. Otherwise each thread has a pool of its own, which keeps
/// the maximum that the thread ever used; a daemon of many threads would grow for hours.
void share_memory_pools();

/// Blocks SIGTERM, SIGINT and SIGHUP for this and all later threads and ignores SIGPIPE. SIGHUP
/// and SIGINT that the process inherited as ignored (nohup, background jobs of a script) stay so.
void block_signals();

/// Waits for one of the blocked signals; returns its number, nothing after `limit`.
[[nodiscard]] std::optional<int> wait_for_signal(std::optional<std::chrono::milliseconds> limit);

/// Whether the process has a controlling terminal. SIGHUP then means that the terminal closes.
[[nodiscard]] bool has_terminal();

/// Unblocks the signals, so that a second SIGTERM ends a process that is stopping.
void unblock_signals();

}  // namespace aprsim::server
