#include "tests/benchmarks/modbus/clients.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <optional>
#include <stdexcept>
#include <string>
#include <sys/epoll.h>
#include <unistd.h>

#include "tests/support/tcp_socket.hpp"

namespace aprsim::bench {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;
using test::TcpSocket;

std::string request(char function, std::uint16_t address, std::uint16_t value) {
  const auto high = [](unsigned v) { return static_cast<char>(v >> 8); };
  const auto low = [](unsigned v) { return static_cast<char>(v & 0xFF); };
  return {0, 1, 0, 0, 0, 6, 1, function, high(address), low(address), high(value), low(value)};
}

/// One well-behaved client: asks on time, whether or not it has been answered.
class Client {
 public:
  Client(std::uint16_t port, Clock::time_point first, Clock::duration period)
      : socket_(port), due_(first), period_(period) {}

  [[nodiscard]] int fd() const { return socket_.fd(); }

  void ask_if_due(Clock::time_point now) {
    if (now < due_) return;
    due_ += period_;
    // In turn: the lab's registers, actual speed and position, the sensors; and the speed is set.
    constexpr std::uint16_t kBase = 0x8000;
    static const std::array kRequests{request(3, kBase, 3), request(4, kBase, 16),
                                      request(2, kBase, 12), request(6, kBase + 2, 15000)};
    const std::string& next = kRequests[asked_++ % kRequests.size()];
    if (socket_.send_some(next) != next.size()) throw std::runtime_error("a client cannot send");
    sent_.push_back(Clock::now());
  }

  void take_replies(std::vector<double>& round_trips_ms) {
    const auto got = socket_.receive_some(std::span(buffer_).subspan(filled_));
    if (!got) return;
    if (*got == 0) throw std::runtime_error("a client has lost its connection");
    filled_ += *got;
    std::size_t at = 0;
    const auto size = [&] { return 6U + static_cast<unsigned char>(buffer_[at + 5]); };
    while (filled_ - at >= 6 && filled_ - at >= size()) {
      at += size();
      const std::chrono::duration<double, std::milli> took = Clock::now() - sent_.front();
      round_trips_ms.push_back(took.count());
      sent_.pop_front();
    }
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(at),
              buffer_.begin() + static_cast<std::ptrdiff_t>(filled_), buffer_.begin());
    filled_ -= at;
  }

  [[nodiscard]] std::size_t unanswered() const { return sent_.size(); }

 private:
  TcpSocket socket_;
  Clock::time_point due_;
  Clock::duration period_;
  std::size_t asked_ = 0, filled_ = 0;
  std::deque<Clock::time_point> sent_;
  std::array<char, 4096> buffer_{};
};

/// Drips a byte a second, and asks for the longest replies without reading any; each comes again
/// when it has been dropped.
class Stallers {
 public:
  explicit Stallers(std::uint16_t port) : port_(port) {}

  void act(Clock::time_point now) {
    if (now >= next_drip_) {
      next_drip_ = now + 1s;
      if (!dripping_ || dripping_->send_some(std::string_view("\0", 1)) != 1U) {
        dripping_.emplace(port_);
      }
    }
    if (now >= next_flood_) {
      next_flood_ = now + 100ms;
      const std::string longest = request(3, 0x8000, 125);
      if (!deaf_) deaf_.emplace(port_);
      for (int i = 0; i < 200; ++i) {
        const auto sent = deaf_->send_some(longest);
        if (sent == longest.size()) continue;
        if (!sent) deaf_.reset();
        break;
      }
    }
  }

 private:
  std::uint16_t port_;
  std::optional<TcpSocket> dripping_, deaf_;
  Clock::time_point next_drip_{}, next_flood_{};
};

/// All clients behind one epoll.
class Crowd {
 public:
  Crowd(std::uint16_t port, std::size_t clients, Clock::time_point begin, Clock::duration period)
      : events_(clients) {
    for (std::size_t i = 0; i < clients; ++i) {
      const auto first =
          begin + static_cast<Clock::rep>(i) * period / static_cast<Clock::rep>(clients);
      clients_.emplace_back(port, first, period);
      epoll_event event{};
      event.events = EPOLLIN;
      event.data.u64 = i;
      ::epoll_ctl(epoll_, EPOLL_CTL_ADD, clients_.back().fd(), &event);
    }
  }
  ~Crowd() { ::close(epoll_); }
  Crowd(const Crowd&) = delete;
  Crowd& operator=(const Crowd&) = delete;

  void ask() {
    const auto now = Clock::now();
    for (auto& client : clients_) client.ask_if_due(now);
  }
  void take_replies(std::vector<double>& round_trips_ms) {
    const int ready = ::epoll_wait(epoll_, events_.data(), static_cast<int>(events_.size()), 1);
    for (int i = 0; i < ready; ++i) {
      clients_[events_[static_cast<std::size_t>(i)].data.u64].take_replies(round_trips_ms);
    }
  }
  [[nodiscard]] std::size_t unanswered() const {
    std::size_t sum = 0;
    for (const auto& client : clients_) sum += client.unanswered();
    return sum;
  }

 private:
  int epoll_ = ::epoll_create1(EPOLL_CLOEXEC);
  std::vector<Client> clients_;
  std::vector<epoll_event> events_;
};

}  // namespace

Load drive(std::uint16_t port, std::size_t clients, double rate_hz, bool stallers,
           std::chrono::seconds duration) {
  const auto begin = Clock::now() + 200ms;
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / rate_hz));
  Crowd crowd(port, clients, begin, period);
  Stallers bad(port);
  Load load;
  load.duration_s = static_cast<double>(duration.count());
  while (Clock::now() < begin + duration) {
    crowd.ask();
    if (stallers) bad.act(Clock::now());
    crowd.take_replies(load.round_trips_ms);
  }
  while (crowd.unanswered() > 0 && Clock::now() < begin + duration + 1s) {
    crowd.take_replies(load.round_trips_ms);
  }
  load.unanswered = crowd.unanswered();
  return load;
}

}  // namespace aprsim::bench
