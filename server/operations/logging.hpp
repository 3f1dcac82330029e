#pragma once

#include <memory>
#include <string>

namespace aprsim::server {

class LogSink;

/// The process's log: standard error, written by a thread of its own, the oldest lines given up and
/// counted when the reader is slow, so that logging never holds up whoever logs. At the end what is
/// queued is written out, as far as the reader takes it within half a second; whoever logs has to
/// end before.
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
