#include "world/runtime/commands/command_queue.hpp"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>
#include <variant>

#include "world/api/commands/stop_command.hpp"

namespace aprsim::world {
namespace {

/// Memory reserved for stops beyond the capacity.
constexpr std::size_t kStops = 64;
/// Each endpoint has 1/kOwnPart of the capacity beyond it. Memory for kEndpoints of them is
/// reserved at construction.
constexpr std::size_t kOwnPart = 16, kEndpoints = 8;
/// Limit of waiting slow commands, so that a stop behind them takes effect soon.
constexpr std::ptrdiff_t kMostSlow = 4;

/// Whether the command takes the time of many steps.
bool is_slow(const api::Command& command) {
  if (std::holds_alternative<api::SceneCommand>(command.body)) return true;
  const auto* simulation = std::get_if<api::SimulationCommand>(&command.body);
  return simulation && (std::holds_alternative<api::Reset>(*simulation) ||
                        std::holds_alternative<api::SaveState>(*simulation) ||
                        std::holds_alternative<api::LoadState>(*simulation));
}

bool same_stop(const api::TrajectoryCommand& a, const api::TrajectoryCommand& b) {
  if (a.robot != b.robot || a.action.index() != b.action.index()) return false;
  if (const auto* stop = std::get_if<api::StopStream>(&a.action)) {
    return stop->stream == std::get<api::StopStream>(b.action).stream;
  }
  return std::get<api::ReleaseMotion>(a.action).stream ==
         std::get<api::ReleaseMotion>(b.action).stream;
}

/// Whether the later of two stops has the effect of both, regardless of their senders.
bool same_stop(const api::Command& a, const api::Command& b) {
  if (a.body.index() != b.body.index() || !api::is_stop(a)) return false;
  if (const auto* robot = std::get_if<api::RobotCommand>(&a.body)) {
    const auto& other = std::get<api::RobotCommand>(b.body);
    return robot->robot == other.robot && std::get<api::StopMotion>(robot->action).kind ==
                                              std::get<api::StopMotion>(other.action).kind;
  }
  if (const auto* stream = std::get_if<api::TrajectoryCommand>(&a.body)) {
    return same_stop(*stream, std::get<api::TrajectoryCommand>(b.body));
  }
  if (const auto* belt = std::get_if<api::ConveyorCommand>(&a.body)) {
    return *belt == std::get<api::ConveyorCommand>(b.body);
  }
  return true;
}

/// A stop of the belt with the effect of two in a row.
api::ConveyorCommand merged(const api::ConveyorCommand& earlier, api::ConveyorCommand later) {
  if (!later.run) later.run = earlier.run;
  if (!later.forward) later.forward = earlier.forward;
  if (!later.speed_m_s) later.speed_m_s = earlier.speed_m_s;
  if (!later.emergency_stop) later.emergency_stop = earlier.emergency_stop;
  if (!later.watchdog_s) later.watchdog_s = earlier.watchdog_s;
  return later;
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
  const bool stop = api::is_stop(command);
  if (stop && queue_.size() >= capacity_) merge_stops(command);
  Share& share = share_of(command.endpoint);
  if (!stop && queue_.size() >= capacity_ && share.waiting >= own_places()) {
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

/// All queued commands act between the same two steps, so the last of equal stops suffices. Another
/// command separates any two remaining stops, so the number of stops is bounded by that of the
/// others.
void CommandQueue::merge_stops(api::Command& stop) {
  const auto drop = [this](const QueuedCommand& queued) {
    --share_of(queued.command.endpoint).waiting;
  };
  std::erase_if(queue_, [&](const QueuedCommand& queued) {
    const bool same = same_stop(queued.command, stop);
    if (same) drop(queued);
    return same;
  });
  auto* const belt = std::get_if<api::ConveyorCommand>(&stop.body);
  if (belt == nullptr) return;
  const auto last = std::find_if(queue_.rbegin(), queue_.rend(), [](const QueuedCommand& queued) {
    return std::holds_alternative<api::ConveyorCommand>(queued.command.body);
  });
  if (last == queue_.rend() || !api::is_stop(last->command)) return;
  *belt = merged(std::get<api::ConveyorCommand>(last->command.body), *belt);
  drop(*last);
  queue_.erase(std::next(last).base());
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
