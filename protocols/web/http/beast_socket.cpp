#include "protocols/web/http/beast_socket.hpp"

#include <chrono>
#include <utility>

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>

namespace aprsim::web {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
using beast::error_code;

constexpr std::size_t kMaxMessageBytes = std::size_t{256} * 1024;  // room for a scene's text
constexpr auto kWriteTimeout = std::chrono::seconds(10);
// Kernel buffer for a slow viewer; data that waits there is stale.
constexpr int kSendBufferBytes = 64 * 1024;

websocket::stream_base::timeout timeouts() {
  return {std::chrono::seconds(5), std::chrono::seconds(20), true};
}

class BeastSocket final : public WebSocket, public std::enable_shared_from_this<BeastSocket> {
 public:
  BeastSocket(WebStream stream, std::function<void()> on_end)
      : stream_(std::move(stream)),
        write_timer_(stream_.get_executor()),
        on_end_(std::move(on_end)) {}

  ~BeastSocket() override {
    if (on_end_) on_end_();
  }

  void accept(beast::http::request<beast::http::empty_body> request,
              std::function<void(std::shared_ptr<WebSocket>)> on_open) {
    auto& tcp = beast::get_lowest_layer(stream_);
    tcp.expires_never();
    error_code ignored;
    tcp.socket().set_option(boost::asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
    stream_.set_option(timeouts());
    stream_.read_message_max(kMaxMessageBytes);
    stream_.auto_fragment(false);
    stream_.binary(true);
    request_ = std::move(request);
    stream_.async_accept(request_, [self = shared_from_this(),
                                    on_open = std::move(on_open)](const error_code& error) {
      if (!error) on_open(self);
    });
  }

  void start(Events events) override {
    events_ = std::move(events);
    read();
  }

  void write(WebMessage message) override {
    if (ended_) return;
    sending_ = std::move(message);
    write_timer_.expires_after(kWriteTimeout);
    write_timer_.async_wait([self = weak_from_this()](const error_code& cancelled) {
      const auto socket = self.lock();
      if (!cancelled && socket) socket->end("write timeout");
    });
    stream_.async_write(boost::asio::buffer(*sending_),
                        [self = shared_from_this()](const error_code& error, std::size_t) {
                          self->on_write(error);
                        });
  }

  void close(const std::string& why, bool fault) override {
    if (ended_ || closing_) return;
    closing_ = true;
    websocket::close_reason reason(
        fault ? websocket::close_code::policy_error : websocket::close_code::going_away, why);
    if (reason.reason.size() > 120) reason.reason = "";
    stream_.async_close(reason,
                        [self = shared_from_this(), why](const error_code&) { self->end(why); });
  }

  void drop() override { end("dropped"); }

 private:
  void read() {
    stream_.async_read(input_, [self = shared_from_this()](const error_code& error, std::size_t) {
      self->on_read(error);
    });
  }

  void on_read(const error_code& error) {
    if (ended_) return;
    if (error)
      return end(error == websocket::error::closed ? "closed by the viewer" : error.message());
    const auto data = input_.cdata();
    if (!closing_) {
      events_.message({static_cast<const char*>(data.data()), data.size()});
    }
    input_.consume(input_.size());
    // The close reads what still comes; a read that waits for it would outlive its timeout.
    if (!ended_ && !closing_) read();
  }

  void on_write(const error_code& error) {
    write_timer_.cancel();
    if (ended_) return;
    if (error) return end(error.message());
    if (!closing_) events_.written();
  }

  void end(const std::string& why) {
    if (std::exchange(ended_, true)) return;
    write_timer_.cancel();
    beast::get_lowest_layer(stream_).close();
    // The handlers may own objects that own this one.
    const Events events = std::exchange(events_, {});
    if (events.end) events.end(why);
  }

  websocket::stream<WebStream> stream_;
  boost::asio::steady_timer write_timer_;
  std::function<void()> on_end_;
  beast::http::request<beast::http::empty_body> request_;
  beast::flat_buffer input_;
  WebMessage sending_;
  Events events_;
  bool closing_ = false, ended_ = false;
};

}  // namespace

void accept_web_socket(WebStream stream, beast::http::request<beast::http::empty_body> request,
                       std::function<void(std::shared_ptr<WebSocket>)> on_open,
                       std::function<void()> on_end) {
  std::make_shared<BeastSocket>(std::move(stream), std::move(on_end))
      ->accept(std::move(request), std::move(on_open));
}

}  // namespace aprsim::web
