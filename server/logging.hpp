#pragma once

#include <string>

namespace aprsim::server {

/// The process's log: standard error, written by a thread of its own, the oldest lines given up
/// when the reader is slow, so that logging never holds up whoever logs. What is queued is written
/// out at the end; whoever logs has to end before.
class Logging {
 public:
  explicit Logging(const std::string& level);
  ~Logging();
  Logging(const Logging&) = delete;
  Logging& operator=(const Logging&) = delete;
};

}  // namespace aprsim::server
