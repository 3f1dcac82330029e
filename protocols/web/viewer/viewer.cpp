#include "protocols/web/viewer/viewer.hpp"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

#include "protocols/web/viewer/viewer_command.hpp"

namespace aprsim::web {
namespace {

constexpr std::size_t kMaxWaiting = 256;
constexpr std::size_t kQuickWaiting = 16;
constexpr double kMaxRequestsPerSecond = 120;

}  // namespace

WebMessage pack(const v1::ViewerUpdate& update) {
  return std::make_shared<const std::string>(update.SerializeAsString());
}

Viewer::Viewer(std::uint64_t id, std::shared_ptr<WebSocket> socket, std::string peer, Events events)
    : id_(id),
      socket_(std::move(socket)),
      peer_(std::move(peer)),
      events_(std::move(events)),
      rate_(kMaxRequestsPerSecond) {}

void Viewer::start() {
  // A weak pointer, since the viewer owns its socket.
  const auto with = [self = weak_from_this()](const auto& act) {
    if (const auto viewer = self.lock()) act(*viewer);
  };
  socket_->start({[with](std::string_view data) { with([&](Viewer& v) { v.on_message(data); }); },
                  [with] { with([](Viewer& v) { v.on_written(); }); },
                  [with](const std::string& why) {
                    with([&](Viewer& v) {
                      spdlog::info("web: viewer {} ended ({})", v.peer_, why);
                      v.closed_ = true;
                      v.trace.closed(why);
                      v.events_.end(v);
                    });
                  }});
}

void Viewer::send(WebMessage message) {
  if (closed_) return;
  waiting_bytes_ += message->size();
  queue_.push_back(std::move(message));
  if (queue_.size() > kMaxWaiting) return close("too slow", true);
  write_next();
}

bool Viewer::send_if_quick(WebMessage message) {
  if (queue_.size() >= kQuickWaiting) return false;
  send(std::move(message));
  return true;
}

bool Viewer::send_latest(std::size_t slot, WebMessage message) {
  if (closed_) return true;
  WebMessage& waiting = latest_[slot];
  const bool replaced = waiting != nullptr;
  if (replaced) waiting_bytes_ -= waiting->size();
  waiting_bytes_ += message->size();
  waiting = std::move(message);
  write_next();
  return !replaced;
}

void Viewer::close(const std::string& why, bool fault) {
  if (std::exchange(closed_, true)) return;
  if (fault) spdlog::warn("web: closing viewer {}: {}", peer_, why);
  queue_.clear();
  latest_.clear();
  waiting_bytes_ = writing_bytes_ = 0;
  socket_->close(why, fault);
}

bool Viewer::due(Clock::time_point now) {
  if (now < next_) return false;
  // Late ticks are not caught up with, and early ones are not counted.
  next_ = next_ + period_ < now ? now + period_ / 2 : next_ + period_;
  return true;
}

void Viewer::set_rate(double hz) {
  period_ = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1 / hz));
}

void Viewer::on_message(std::string_view data) {
  if (closed_) return;
  v1::ViewerRequest request;
  if (!request.ParseFromArray(data.data(), static_cast<int>(data.size()))) {
    return close("not a ViewerRequest", true);
  }
  if (!rate_.admit(Clock::now())) {
    // A stop is never refused.
    if (is_stop(request)) events_.request(*this, request);
    return close("too many requests", true);
  }
  events_.request(*this, request);
}

void Viewer::on_written() {
  writing_ = false;
  waiting_bytes_ -= std::exchange(writing_bytes_, 0);
  write_next();
}

void Viewer::write_next() {
  if (writing_ || closed_) return;
  WebMessage message;
  if (!queue_.empty()) {
    message = std::move(queue_.front());
    queue_.pop_front();
  } else {
    const auto next =
        std::ranges::find_if(latest_, [](const auto& slot) { return slot.second != nullptr; });
    if (next == latest_.end()) return;
    message = std::exchange(next->second, nullptr);
  }
  writing_ = true;
  writing_bytes_ = message->size();
  socket_->write(std::move(message));
}

}  // namespace aprsim::web
