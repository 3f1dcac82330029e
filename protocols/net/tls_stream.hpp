#pragma once

#include <memory>
#include <utility>
#include <variant>

#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>

namespace aprsim::protocols {

/// A client's socket, encrypted or not, for Asio's operations with handlers. An encrypted one is
/// read and written after its handshake. For use inside a listener; do not include it in other
/// headers. Thread: the listener's.
template <typename Tcp>
class TlsStream {
 public:
  using next_layer_type = Tcp;
  using executor_type = typename Tcp::executor_type;

  /// Without a context: not encrypted.
  explicit TlsStream(Tcp tcp, std::shared_ptr<boost::asio::ssl::context> context = nullptr)
      : context_(std::move(context)), stream_(std::move(tcp)) {
    if (!context_) return;
    auto secure = std::make_unique<Secure>(std::move(std::get<Tcp>(stream_)), *context_);
    stream_ = std::move(secure);
  }

  [[nodiscard]] bool is_secure() const { return context_ != nullptr; }
  [[nodiscard]] executor_type get_executor() { return next_layer().get_executor(); }
  [[nodiscard]] Tcp& next_layer() {
    return is_secure() ? secure().next_layer() : std::get<Tcp>(stream_);
  }
  /// Only where the stream is encrypted.
  [[nodiscard]] SSL* native_handle() { return secure().native_handle(); }

  template <typename Handler>
  void async_handshake(Handler&& handler) {
    secure().async_handshake(boost::asio::ssl::stream_base::server, std::forward<Handler>(handler));
  }
  /// Sends close_notify on an encrypted stream and waits for the client's.
  template <typename Handler>
  void async_shutdown(Handler&& handler) {
    secure().async_shutdown(std::forward<Handler>(handler));
  }
  template <typename Buffers, typename Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    if (is_secure()) {
      secure().async_read_some(buffers, std::forward<Handler>(handler));
    } else {
      next_layer().async_read_some(buffers, std::forward<Handler>(handler));
    }
  }
  template <typename Buffers, typename Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    if (is_secure()) {
      secure().async_write_some(buffers, std::forward<Handler>(handler));
    } else {
      next_layer().async_write_some(buffers, std::forward<Handler>(handler));
    }
  }

 private:
  using Secure = boost::asio::ssl::stream<Tcp>;
  [[nodiscard]] Secure& secure() { return *std::get<std::unique_ptr<Secure>>(stream_); }

  std::shared_ptr<boost::asio::ssl::context> context_;
  std::variant<Tcp, std::unique_ptr<Secure>> stream_;
};

}  // namespace aprsim::protocols
