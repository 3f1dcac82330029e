#include "protocols/modbus/deadlines.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::modbus_server {
namespace {

std::string millis(std::chrono::milliseconds time) { return std::to_string(time.count()) + " ms"; }

}  // namespace

Deadlines::Deadlines(const boost::asio::any_io_executor& io, const ModbusServerOptions& options,
                     std::function<void()> on_due)
    : options_(options), on_due_(std::move(on_due)), timer_(io) {}

void Deadlines::begin_request() {
  if (request_due_ == kNever) request_due_ = Clock::now() + options_.partial_timeout;
}

void Deadlines::restart_idle() {
  if (options_.idle_timeout.count() > 0) idle_due_ = Clock::now() + options_.idle_timeout;
}

// A timer that fires early finds nothing due and is restarted. So an ordinary request costs no
// timer operation.
void Deadlines::watch(std::shared_ptr<const void> owner) {
  const Clock::time_point due = std::min({handshake_due_, request_due_, write_due_, idle_due_});
  if (closed_ || due >= timer_at_) return;
  timer_at_ = due;
  timer_.expires_at(due);
  timer_.async_wait([this, owner = std::move(owner)](const boost::system::error_code& error) {
    if (error || closed_) return;
    timer_at_ = kNever;
    on_due_();
  });
}

std::string Deadlines::missed(bool waits_for_us) {
  const Clock::time_point now = Clock::now();
  if (now >= handshake_due_) return "no TLS handshake within " + millis(options_.handshake_timeout);
  if (now >= request_due_) {
    return "a request was incomplete for " + millis(options_.partial_timeout);
  }
  if (now >= write_due_) return "it did not take its replies for " + millis(options_.write_timeout);
  if (now < idle_due_) return {};
  if (!waits_for_us) return "no request for " + millis(options_.idle_timeout);
  idle_due_ = now + options_.idle_timeout;
  return {};
}

void Deadlines::close() {
  closed_ = true;
  timer_.cancel();
}

}  // namespace aprsim::modbus_server
