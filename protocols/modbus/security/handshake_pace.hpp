#pragma once

#include <deque>
#include <functional>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/steady_timer.hpp>

#include "world/base/rate_limit.hpp"

namespace aprsim::modbus_server {

/// Starts TLS handshakes in the order of their connections: kBurst at once, then kPerSecond. A
/// flood of handshakes so leaves the thread to the requests of other clients. Thread: the
/// executor's.
class HandshakePace {
 public:
  static constexpr double kBurst = 16, kPerSecond = 100;

  explicit HandshakePace(const boost::asio::any_io_executor& io) : timer_(io) {}

  /// Calls `start` now or in its turn, unless `connection` leaves before.
  void admit(const void* connection, std::function<void()> start);
  void leave(const void* connection);

 private:
  struct Waiting {
    const void* connection = nullptr;
    std::function<void()> start;
  };

  void start_waiting();

  protocols::RateLimit limit_{kPerSecond, kBurst};
  std::deque<Waiting> waiting_;
  boost::asio::steady_timer timer_;
  bool timed_ = false;
};

}  // namespace aprsim::modbus_server
