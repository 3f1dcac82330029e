#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace aprsim::web {

/// A serialised message for any number of viewers.
using WebMessage = std::shared_ptr<const std::string>;

/// One open WebSocket. Stays alive while an operation is pending. Thread: the server's.
class WebSocket {
 public:
  struct Events {
    std::function<void(std::string_view)> message;    ///< a binary message was received
    std::function<void()> written;                    ///< the last message was sent
    std::function<void(const std::string& why)> end;  ///< once, after closing
  };
  virtual ~WebSocket() = default;

  virtual void start(Events events) = 0;
  /// Sends a message. Call it again only after `written`.
  virtual void write(WebMessage message) = 0;
  /// Closes with a reason for the peer; `end` follows.
  virtual void close(const std::string& why, bool fault) = 0;
  /// Closes without a handshake; `end` follows immediately.
  virtual void drop() = 0;
};

}  // namespace aprsim::web
