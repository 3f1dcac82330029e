#pragma once

#include <memory>
#include <string>

namespace aprsim::server {

class LogSink;

/// The log of the process. A thread of its own writes it to standard error. With a slow reader the
/// oldest lines are dropped and counted, so that logging never blocks. The destructor writes what
/// is queued, for half a second at most; all threads that log have to end before.
class Logging {
 public:
  explicit Logging(const std::string& level);
  ~Logging();
  Logging(const Logging&) = delete;
  Logging& operator=(const Logging&) = delete;

 private:
  std::shared_ptr<LogSink> sink_;
};

}  // namespace aprsim::server
