#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace aprsim::web {

/// A message on its way to any number of viewers.
using WebMessage = std::shared_ptr<const std::string>;

/// One open WebSocket. Keeps itself alive while an operation is pending. Thread: the server's.
class WebSocket {
 public:
  struct Events {
    std::function<void(std::string_view)> message;    ///< one binary message has come in
    std::function<void()> written;                    ///< the last message is out
    std::function<void(const std::string& why)> end;  ///< once, when it has been closed
  };
  virtual ~WebSocket() = default;

  virtual void start(Events events) = 0;
  /// One at a time: the next only after `written`.
  virtual void write(WebMessage message) = 0;
  /// Closes with a reason that the peer sees; `end` follows.
  virtual void close(const std::string& why, bool fault) = 0;
  /// Closes without a goodbye; `end` follows at once.
  virtual void drop() = 0;
};

}  // namespace aprsim::web
