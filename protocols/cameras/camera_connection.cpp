#include "protocols/cameras/camera_connection.hpp"

#include <string_view>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/write.hpp>

namespace aprsim::camera_server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

// Pictures in the kernel are stale for a slow reader.
constexpr int kSendBufferBytes = 64 * 1024;
constexpr std::string_view kEndOfHead = "\r\n\r\n";

}  // namespace

CameraConnection::CameraConnection(asio::ip::tcp::socket socket, protocols::LimitedLog& log,
                                   std::string peer, protocols::ConnectionLimiter::Slot slot,
                                   const CameraServerOptions& options, CameraCounters& counters,
                                   std::function<void()> on_wanted, OnEnd on_end)
    : socket_(std::move(socket)),
      log_(log),
      peer_(std::move(peer)),
      slot_(std::move(slot)),
      options_(options),
      counters_(counters),
      on_wanted_(std::move(on_wanted)),
      on_end_(std::move(on_end)),
      deadline_(socket_.get_executor()) {
  error_code ignored;
  socket_.set_option(asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
}

void CameraConnection::start() {
  set_deadline();
  read();
}

void CameraConnection::set_deadline() {
  deadline_.expires_after(options_.timeout);
  deadline_.async_wait([self = weak_from_this()](const error_code& cancelled) {
    const auto connection = self.lock();
    if (cancelled || !connection) return;
    connection->drop(connection->answered_ ? "it did not take pictures in time"
                                           : "it sent no request in time");
  });
}

void CameraConnection::read() {
  socket_.async_read_some(asio::buffer(input_),
                          [self = shared_from_this()](const error_code& error, std::size_t size) {
                            if (self->closed_) return;
                            if (!error) return self->on_read(size);
                            // A client that has ended its side after the request still gets its
                            // pictures.
                            if (error == asio::error::eof && self->answered_) return;
                            self->close();
                          });
}

void CameraConnection::on_read(std::size_t size) {
  // After the request nothing is expected, and what comes is discarded.
  if (answered_) return read();
  head_.append(input_.data(), size);
  if (head_.find(kEndOfHead) != std::string::npos) {
    answer();
  } else if (head_.size() > kMaxHead) {
    return drop("a request with more than 8 KiB");
  }
  if (!closed_) read();
}

void CameraConnection::answer() {
  using Kind = CameraRequest::Kind;
  answered_ = true;
  slot_.used();
  error_code ignored;
  deadline_.cancel(ignored);
  request_ = read_request(head_);
  head_.clear();
  if (request_.kind != Kind::kVideo && request_.kind != Kind::kImage) {
    log_.warn(peer_ + ": refused a request: this camera has /mjpg/video.mjpg and /jpg/image.jpg");
    last_ = true;
    return send(refusal(request_.kind), nullptr);
  }
  if (request_.kind == Kind::kVideo) {
    log_.info(peer_ + " connected");
    slot_.keep();
    last_ = request_.head;
    return send(video_head(), nullptr);
  }
  wants_ = true;
  on_wanted_();
}

void CameraConnection::offer(const Jpeg& picture) {
  if (closed_ || !wants_) return;
  if (busy_) {
    if (next_) ++counters_.skipped;
    next_ = picture;
    return;
  }
  if (request_.kind == CameraRequest::Kind::kVideo) {
    return send(part_head(picture->size()), picture);
  }
  last_ = true;
  wants_ = false;
  send(image_head(picture->size()), request_.head ? nullptr : picture);
}

void CameraConnection::send(std::string head, Jpeg picture) {
  busy_ = true;
  sending_head_ = std::move(head);
  sending_ = std::move(picture);
  set_deadline();
  write();
}

void CameraConnection::write() {
  static const std::string none;
  const std::string& body = sending_ ? *sending_ : none;
  const bool part = sending_ && request_.kind == CameraRequest::Kind::kVideo;
  const std::array<asio::const_buffer, 3> pieces = {
      asio::buffer(sending_head_), asio::buffer(body),
      asio::buffer(std::string_view(part ? "\r\n" : ""))};
  asio::async_write(socket_, pieces,
                    [self = shared_from_this()](const error_code& error, std::size_t) {
                      if (self->closed_) return;
                      if (!error) return self->on_sent();
                      self->log_.info(self->peer_ + " disconnected (" + error.message() + ")");
                      self->close();
                    });
}

void CameraConnection::on_sent() {
  busy_ = false;
  sending_.reset();
  error_code ignored;
  deadline_.cancel(ignored);
  if (last_) return close();
  wants_ = true;
  if (Jpeg next = std::exchange(next_, nullptr)) return offer(next);
  on_wanted_();
}

void CameraConnection::drop(const std::string& why) {
  if (closed_) return;
  ++counters_.dropped;
  log_.warn("closing " + peer_ + ": " + why);
  close();
}

void CameraConnection::close() {
  if (closed_) return;
  closed_ = true;
  error_code ignored;
  deadline_.cancel(ignored);
  socket_.shutdown(asio::ip::tcp::socket::shutdown_both, ignored);
  socket_.close(ignored);
  on_end_(*this);
}

}  // namespace aprsim::camera_server
