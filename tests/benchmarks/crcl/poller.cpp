#include "tests/benchmarks/crcl/poller.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <memory>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdexcept>
#include <string>
#include <string_view>
#include <sys/socket.h>
#include <unistd.h>

namespace aprsim::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::string_view kRequest =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?><CRCLCommandInstance><CRCLCommand "
    "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:type=\"GetStatusType\">"
    "<CommandID>7</CommandID></CRCLCommand></CRCLCommandInstance>";
constexpr std::string_view kEnd = "</CRCLStatus>";

class Poller {
 public:
  Poller(std::uint16_t port, Clock::time_point first) : due_(first) {
    fd_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      throw std::runtime_error("cannot connect");
    }
    const int on = 1;
    ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  }
  ~Poller() { ::close(fd_); }
  Poller(const Poller&) = delete;
  Poller& operator=(const Poller&) = delete;

  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] Clock::time_point due() const { return asked_ ? Clock::time_point::max() : due_; }

  void ask_if_due(std::chrono::microseconds period) {
    const auto now = Clock::now();
    if (asked_ || now < due_) return;
    due_ = std::max(due_ + period, now);
    asked_ = true;
    sent_ = Clock::now();
    if (::send(fd_, kRequest.data(), kRequest.size(), MSG_NOSIGNAL) !=
        static_cast<ssize_t>(kRequest.size())) {
      throw std::runtime_error("a client cannot send");
    }
  }

  void read(Polls& polls) {
    char bytes[16384];
    const ssize_t size = ::recv(fd_, bytes, sizeof bytes, 0);
    if (size <= 0) throw std::runtime_error("a client lost its connection");
    answer_.append(bytes, static_cast<std::size_t>(size));
    if (!answer_.ends_with(kEnd)) return;
    const std::chrono::duration<double, std::micro> took = Clock::now() - sent_;
    polls.round_trips_us.push_back(took.count());
    polls.bytes = answer_.size();
    answer_.clear();
    asked_ = false;
  }

 private:
  int fd_ = -1;
  Clock::time_point due_, sent_;
  bool asked_ = false;
  std::string answer_;
};

}  // namespace

Polls poll_statuses(std::uint16_t port, std::size_t clients, std::chrono::microseconds period,
                    std::chrono::seconds duration) {
  const auto begin = Clock::now() + std::chrono::milliseconds(200);
  std::vector<std::unique_ptr<Poller>> pollers;
  std::vector<pollfd> events;
  for (std::size_t i = 0; i < clients; ++i) {
    const auto offset = static_cast<Clock::rep>(i) * period / static_cast<Clock::rep>(clients);
    pollers.push_back(std::make_unique<Poller>(port, begin + offset));
    events.push_back({pollers.back()->fd(), POLLIN, 0});
  }
  Polls polls;
  while (Clock::now() < begin + duration) {
    auto next = Clock::time_point::max();
    for (auto& poller : pollers) {
      poller->ask_if_due(period);
      next = std::min(next, poller->due());
    }
    const auto wait = std::clamp(next - Clock::now(), Clock::duration::zero(),
                                 Clock::duration(std::chrono::milliseconds(10)));
    const timespec limit{0, static_cast<long>(wait.count())};
    if (::ppoll(events.data(), events.size(), &limit, nullptr) <= 0) continue;
    for (std::size_t i = 0; i < clients; ++i) {
      if (events[i].revents != 0) pollers[i]->read(polls);
    }
  }
  return polls;
}

}  // namespace aprsim::bench
