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

constexpr std::chrono::seconds kLongest{10};  // that an answer takes

}  // namespace

class StatusPollers::Poller {
 public:
  explicit Poller(std::uint16_t port) : socket_(port) {}

  [[nodiscard]] int fd() const { return socket_.fd(); }
  [[nodiscard]] bool waits() const { return asked_; }
  void begin(Clock::time_point first) { due_ = first; }
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

StatusPollers::StatusPollers(std::uint16_t port, std::size_t clients,
                             std::chrono::microseconds period)
    : period_(period) {
  for (std::size_t i = 0; i < clients; ++i) pollers_.emplace_back(port);
}

StatusPollers::~StatusPollers() = default;
StatusPollers::StatusPollers(StatusPollers&&) noexcept = default;

void StatusPollers::run(std::chrono::milliseconds duration, Polls& polls) {
  const auto begin = Clock::now(), end = begin + duration;
  std::vector<pollfd> events;
  for (std::size_t i = 0; i < pollers_.size(); ++i) {
    pollers_[i].begin(begin + static_cast<Clock::rep>(i) * period_ /
                                  static_cast<Clock::rep>(pollers_.size()));
    events.push_back({pollers_[i].fd(), POLLIN, 0});
  }
  while (Clock::now() < end || std::ranges::any_of(pollers_, &Poller::waits)) {
    if (Clock::now() > end + kLongest) throw std::runtime_error("a status does not come");
    auto next = Clock::time_point::max();
    for (auto& poller : pollers_) {
      if (Clock::now() < end) poller.ask_if_due(period_);
      next = std::min(next, poller.due());
    }
    const auto wait = std::clamp(next - Clock::now(), Clock::duration::zero(),
                                 Clock::duration(std::chrono::milliseconds(10)));
    const timespec limit{0, static_cast<long>(wait.count())};
    if (::ppoll(events.data(), events.size(), &limit, nullptr) <= 0) continue;
    for (std::size_t i = 0; i < pollers_.size(); ++i) {
      if (events[i].revents != 0) pollers_[i].read(polls);
    }
  }
}

}  // namespace aprsim::bench
