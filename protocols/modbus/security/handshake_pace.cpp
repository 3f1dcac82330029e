#include "protocols/modbus/security/handshake_pace.hpp"

#include <chrono>
#include <utility>

namespace aprsim::modbus_server {

void HandshakePace::admit(const void* connection, std::function<void()> start) {
  waiting_.push_back({connection, std::move(start)});
  if (!timed_) start_waiting();
}

void HandshakePace::leave(const void* connection) {
  std::erase_if(waiting_, [&](const Waiting& waiting) { return waiting.connection == connection; });
}

void HandshakePace::start_waiting() {
  constexpr auto kTurn = std::chrono::duration<double>(1 / kPerSecond);
  while (!waiting_.empty() && limit_.admit(protocols::RateLimit::Clock::now())) {
    const auto start = std::move(waiting_.front().start);
    waiting_.pop_front();
    start();
  }
  timed_ = !waiting_.empty();
  if (!timed_) return;
  timer_.expires_after(std::chrono::duration_cast<std::chrono::nanoseconds>(kTurn));
  timer_.async_wait([this](const boost::system::error_code& cancelled) {
    if (!cancelled) start_waiting();
  });
}

}  // namespace aprsim::modbus_server
