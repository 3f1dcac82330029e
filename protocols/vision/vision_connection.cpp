#include "protocols/vision/vision_connection.hpp"

#include <string_view>
#include <utility>

#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>

#include "protocols/net/foreign_protocol.hpp"

namespace aprsim::vision_server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

// A small buffer: lines in the kernel are stale for a slow reader.
constexpr int kSendBufferBytes = 8 * 1024;

}  // namespace

VisionConnection::VisionConnection(asio::ip::tcp::socket socket, protocols::LimitedLog& log,
                                   std::string peer, protocols::ConnectionLimiter::Slot slot,
                                   protocols::ConnectionTrace trace,
                                   const VisionServerOptions& options, VisionCounters& counters,
                                   std::function<void()> on_idle, OnEnd on_end)
    : socket_(std::move(socket)),
      log_(log),
      peer_(std::move(peer)),
      slot_(std::move(slot)),
      trace_(std::move(trace)),
      options_(options),
      counters_(counters),
      on_idle_(std::move(on_idle)),
      on_end_(std::move(on_end)),
      write_timer_(socket_.get_executor()) {
  error_code ignored;
  socket_.set_option(asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
  // Readers send no requests; one that does not read is dropped anyway.
  slot_.keep();
}

void VisionConnection::start() {
  log_.info(peer_ + " connected");
  read();
}

void VisionConnection::offer(VisionLine line) {
  if (closed_ || draining_) return;
  if (next_) ++counters_.skipped;
  next_ = std::move(line);
  if (!sending_) send_next();
}

void VisionConnection::drain() {
  draining_ = true;
  next_.reset();
  if (!sending_) close();
}

void VisionConnection::close() {
  if (closed_) return;
  closed_ = true;
  error_code ignored;
  write_timer_.cancel(ignored);
  socket_.shutdown(asio::ip::tcp::socket::shutdown_both, ignored);
  socket_.close(ignored);
  trace_.closed(end_);
  on_end_(*this);
}

void VisionConnection::read() {
  socket_.async_read_some(
      asio::buffer(input_), [self = shared_from_this()](const error_code& error, std::size_t size) {
        if (self->closed_ || error == asio::error::eof) return;
        if (!error) return self->on_read(size);
        self->log_.info(self->peer_ + " disconnected (" + error.message() + ")");
        self->end_ = "by the client";
        self->close();
      });
}

void VisionConnection::on_read(std::size_t size) {
  if (!std::exchange(heard_, true)) {
    const std::string_view protocol = protocols::foreign_protocol({input_.data(), size});
    if (!protocol.empty()) {
      return drop("it speaks " + std::string(protocol) + ", not the vision protocol");
    }
  }
  read();
}

void VisionConnection::drop(const std::string& why) {
  if (closed_) return;
  ++counters_.dropped;
  log_.warn("closing " + peer_ + ": " + why);
  end_ = why;
  close();
}

void VisionConnection::send_next() {
  sending_ = std::move(next_);
  next_.reset();
  sent_ = 0;
  write_timer_.expires_after(options_.write_timeout);
  write_timer_.async_wait([self = weak_from_this()](const error_code& cancelled) {
    const auto connection = self.lock();
    if (!cancelled && connection) connection->drop("it did not take frames in time");
  });
  write();
}

void VisionConnection::write() {
  socket_.async_write_some(asio::buffer(sending_->data() + sent_, sending_->size() - sent_),
                           [self = shared_from_this()](const error_code& error, std::size_t size) {
                             self->on_write(error, size);
                           });
}

void VisionConnection::on_write(const error_code& error, std::size_t size) {
  if (closed_) return;
  if (error) {
    log_.info(peer_ + " disconnected (" + error.message() + ")");
    end_ = "by the client";
    return close();
  }
  sent_ += size;
  if (sent_ < sending_->size()) return write();
  trace_.sent(*sending_);
  sending_.reset();
  error_code ignored;
  write_timer_.cancel(ignored);
  if (next_) {
    send_next();
  } else if (draining_) {
    close();
  } else {
    on_idle_();
  }
}

}  // namespace aprsim::vision_server
