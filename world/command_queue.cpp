#include "world/command_queue.hpp"

#include <string>
#include <utility>

namespace aprsim::world {

CommandQueue::CommandQueue(std::size_t capacity) : capacity_(capacity) { queue_.reserve(capacity); }

Result<api::Ticket> CommandQueue::push(api::Command command) {
  const std::lock_guard lock(mutex_);
  if (closed_) return fail(ErrorCode::kUnavailable, "simulation", "the simulation has ended");
  if (queue_.size() >= capacity_) {
    return fail(ErrorCode::kUnavailable, "command queue",
                std::to_string(capacity_) + " commands wait already; try again later");
  }
  queue_.push_back({++last_ticket_, std::move(command)});
  filled_.notify_one();
  return last_ticket_;
}

void CommandQueue::drain(std::vector<QueuedCommand>& out) {
  out.clear();
  const std::lock_guard lock(mutex_);
  std::swap(out, queue_);
  // Both vectors keep their capacity, so that neither side allocates again.
  queue_.reserve(capacity_);
}

void CommandQueue::wait_until(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  filled_.wait_until(lock, deadline, [this] { return closed_ || !queue_.empty(); });
}

void CommandQueue::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  filled_.notify_all();
}

}  // namespace aprsim::world
