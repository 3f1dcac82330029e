#include "tests/benchmarks/crcl/poller.hpp"

#include <algorithm>
#include <array>
#include <poll.h>
#include <stdexcept>
#include <string>
#include <string_view>

#include "tests/support/tcp_socket.hpp"

namespace aprsim::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::string_view kRequest =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?><CRCLCommandInstance><CRCLCommand "
    "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:type=\"GetStatusType\">"
    "<CommandID>7</CommandID></CRCLCommand></CRCLCommandInstance>";
constexpr std::string_view kAnswerEnd = "</CRCLStatus>";

class Poller {
 public:
  Poller(std::uint16_t port, Clock::time_point first) : socket_(port), due_(first) {}

  [[nodiscard]] int fd() const { return socket_.fd(); }
  [[nodiscard]] Clock::time_point due() const { return asked_ ? Clock::time_point::max() : due_; }

  void ask_if_due(std::chrono::microseconds period) {
    const auto now = Clock::now();
    if (asked_ || now < due_) return;
    due_ = std::max(due_ + period, now);
    asked_ = true;
    sent_ = Clock::now();
    if (!socket_.send(kRequest)) throw std::runtime_error("a client cannot send");
  }

  void read(Polls& polls) {
    std::array<char, 16384> bytes;
    const auto size = socket_.receive_some(bytes);
    if (!size) return;
    if (*size == 0) throw std::runtime_error("a client lost its connection");
    answer_.append(bytes.data(), *size);
    if (!answer_.ends_with(kAnswerEnd)) return;
    const std::chrono::duration<double, std::micro> took = Clock::now() - sent_;
    polls.round_trips_us.push_back(took.count());
    polls.bytes = answer_.size();
    answer_.clear();
    asked_ = false;
  }

 private:
  test::TcpSocket socket_;
  Clock::time_point due_, sent_;
  bool asked_ = false;
  std::string answer_;
};

}  // namespace

Polls poll_statuses(std::uint16_t port, std::size_t clients, std::chrono::microseconds period,
                    std::chrono::seconds duration) {
  const auto begin = Clock::now() + std::chrono::milliseconds(200);
  std::vector<Poller> pollers;
  std::vector<pollfd> events;
  for (std::size_t i = 0; i < clients; ++i) {
    const auto offset = static_cast<Clock::rep>(i) * period / static_cast<Clock::rep>(clients);
    pollers.emplace_back(port, begin + offset);
    events.push_back({pollers.back().fd(), POLLIN, 0});
  }
  Polls polls;
  while (Clock::now() < begin + duration) {
    auto next = Clock::time_point::max();
    for (auto& poller : pollers) {
      poller.ask_if_due(period);
      next = std::min(next, poller.due());
    }
    const auto wait = std::clamp(next - Clock::now(), Clock::duration::zero(),
                                 Clock::duration(std::chrono::milliseconds(10)));
    const timespec limit{0, static_cast<long>(wait.count())};
    if (::ppoll(events.data(), events.size(), &limit, nullptr) <= 0) continue;
    for (std::size_t i = 0; i < clients; ++i) {
      if (events[i].revents != 0) pollers[i].read(polls);
    }
  }
  return polls;
}

}  // namespace aprsim::bench
