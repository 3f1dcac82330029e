#include "world/runtime/commands/command_queue.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

namespace aprsim::world {
namespace {

/// Places beyond the capacity, for stops. No two of them are the same.
constexpr std::size_t kStops = 64;
/// Each endpoint has 1/kOwnPart of the capacity beyond it. Memory for kEndpoints of them is
/// reserved at construction.
constexpr std::size_t kOwnPart = 16, kEndpoints = 8;
/// Slow commands that may wait at once, so that a stop behind them takes effect soon.
constexpr std::ptrdiff_t kMostSlow = 4;

const api::StopMotion* stop_of(const api::RobotCommand& command) {
  return std::get_if<api::StopMotion>(&command.action);
}

bool is_stop(const api::ConveyorCommand& belt) {
  const bool stops = belt.run == false || belt.emergency_stop == true;
  return stops && belt.run != true && belt.emergency_stop != false && !belt.fault_reset;
}

bool is_stop(const api::Command& command) {
  if (const auto* robot = std::get_if<api::RobotCommand>(&command.body)) return stop_of(*robot);
  if (const auto* belt = std::get_if<api::ConveyorCommand>(&command.body)) return is_stop(*belt);
  const auto* simulation = std::get_if<api::SimulationCommand>(&command.body);
  return simulation && std::holds_alternative<api::Pause>(*simulation);
}

/// Whether the command takes as long as many steps.
bool is_slow(const api::Command& command) {
  if (std::holds_alternative<api::SceneCommand>(command.body)) return true;
  const auto* simulation = std::get_if<api::SimulationCommand>(&command.body);
  return simulation && (std::holds_alternative<api::Reset>(*simulation) ||
                        std::holds_alternative<api::SaveState>(*simulation) ||
                        std::holds_alternative<api::LoadState>(*simulation));
}

/// Whether one of two stops is enough, regardless of their senders.
bool same_stop(const api::Command& a, const api::Command& b) {
  if (a.body.index() != b.body.index() || !is_stop(a)) return false;
  if (const auto* robot = std::get_if<api::RobotCommand>(&a.body)) {
    const auto& other = std::get<api::RobotCommand>(b.body);
    const api::StopMotion* stop = stop_of(other);
    return stop && robot->robot == other.robot && stop_of(*robot)->kind == stop->kind;
  }
  if (const auto* belt = std::get_if<api::ConveyorCommand>(&a.body)) {
    return *belt == std::get<api::ConveyorCommand>(b.body);
  }
  return true;
}

}  // namespace

CommandQueue::CommandQueue(std::size_t capacity) : capacity_(capacity) {
  queue_.reserve(room());
  shares_.reserve(kEndpoints);
}

std::size_t CommandQueue::room() const { return capacity_ + kEndpoints * own_places() + kStops; }

std::size_t CommandQueue::own_places() const { return capacity_ / kOwnPart; }

Result<api::Ticket> CommandQueue::push(api::Command command) {
  const std::lock_guard lock(mutex_);
  if (closed_) return fail(ErrorCode::kUnavailable, "simulation", "the simulation has ended");
  if (queue_.size() >= capacity_ && is_stop(command)) drop_same_stop(command);
  Share& share = share_of(command.endpoint);
  const std::size_t stops = is_stop(command) ? shares_.size() * own_places() + kStops : 0;
  const bool full = queue_.size() >= capacity_ + stops;
  if (full && share.waiting >= own_places()) {
    return fail(ErrorCode::kUnavailable, "command queue",
                std::to_string(capacity_) + " commands wait already; try again later");
  }
  const auto slow = [](const QueuedCommand& queued) { return is_slow(queued.command); };
  if (is_slow(command) && std::count_if(queue_.begin(), queue_.end(), slow) >= kMostSlow) {
    return fail(ErrorCode::kUnavailable, "command queue",
                std::to_string(kMostSlow) +
                    " resets, saves and loads wait already; try again once they are done");
  }
  queue_.push_back({++last_ticket_, std::move(command)});
  ++share.waiting;
  ++changes_;
  filled_.notify_one();
  return last_ticket_;
}

void CommandQueue::drain(std::vector<QueuedCommand>& out) {
  out.clear();
  const std::lock_guard lock(mutex_);
  std::swap(out, queue_);
  // Both vectors keep their capacity, so that neither side allocates again.
  queue_.reserve(room());
  for (Share& share : shares_) share.waiting = 0;
}

std::size_t CommandQueue::size() const {
  const std::lock_guard lock(mutex_);
  return queue_.size();
}

/// The same stop, later, does what the earlier one would do: both act between the same two steps.
void CommandQueue::drop_same_stop(const api::Command& stop) {
  std::erase_if(queue_, [&](const QueuedCommand& queued) {
    const bool drop = is_stop(queued.command) && same_stop(queued.command, stop);
    if (drop) --share_of(queued.command.endpoint).waiting;
    return drop;
  });
}

CommandQueue::Share& CommandQueue::share_of(api::EndpointId endpoint) {
  const auto found = std::ranges::find(shares_, endpoint, &Share::endpoint);
  return found != shares_.end() ? *found : shares_.emplace_back(Share{endpoint});
}

bool CommandQueue::holds_other_than(std::span<const api::EndpointId> endpoints) {
  const std::lock_guard lock(mutex_);
  return std::ranges::any_of(queue_, [&](const QueuedCommand& queued) {
    return std::ranges::find(endpoints, queued.command.endpoint) == endpoints.end();
  });
}

std::uint64_t CommandQueue::changes() {
  const std::lock_guard lock(mutex_);
  return changes_;
}

void CommandQueue::notify() {
  const std::lock_guard lock(mutex_);
  ++changes_;
  filled_.notify_one();
}

void CommandQueue::wait_until(std::uint64_t seen, std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  filled_.wait_until(lock, deadline, [&] { return closed_ || changes_ != seen; });
}

void CommandQueue::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  filled_.notify_all();
}

}  // namespace aprsim::world
