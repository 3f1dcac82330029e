#pragma once

#include <string>

namespace aprsim::server {

/// Sets up the process's log: standard error, written by a thread of its own, the oldest lines
/// given up when the reader is slow, so that logging never holds up whoever logs.
void start_logging(const std::string& level);
/// Writes out what is queued and ends the thread.
void stop_logging();

}  // namespace aprsim::server
