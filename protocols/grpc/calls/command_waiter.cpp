#include "protocols/grpc/calls/command_waiter.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::grpc_server {

using std::chrono::steady_clock;

namespace {
// Longest wait for a snapshot: bounds the delay in detecting a cancelled or overdue call when the
// cell is paused and publishes nothing.
constexpr auto kLook = std::chrono::milliseconds(20);
// The same while all wait for a later step: bounds the delay of a new call.
constexpr auto kLookForStep = std::chrono::milliseconds(2);

grpc::Status stopping() { return {grpc::StatusCode::UNAVAILABLE, "the server is stopping"}; }
}  // namespace

CommandWaiter::CommandWaiter(const api::SnapshotSource& source)
    : source_(source), thread_([this] { run(); }) {}

CommandWaiter::~CommandWaiter() { stop(); }

void CommandWaiter::wait(Call call) {
  const std::lock_guard lock(mutex_);
  if (stopping_) {
    call.finish(stopping());
    return;
  }
  // Checking with the list locked leaves no gap in which the decisive snapshot could be missed.
  if (finish_if_over(call, *source_.latest())) return;
  calls_.push_back(std::move(call));
  changed_.notify_all();
}

void CommandWaiter::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    for (auto& call : calls_) call.finish(stopping());
    calls_.clear();
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

bool CommandWaiter::finish_if_over(Call& call, const api::Snapshot& snapshot) {
  if (auto status = call.outcome(snapshot)) {
    call.finish(*status);
    return true;
  }
  const bool cancelled = call.context->IsCancelled();
  if (!cancelled && steady_clock::now() < call.deadline) return false;
  if (call.confirm && !cancelled) {
    call.confirm(snapshot);
    call.finish(grpc::Status::OK);
    return true;
  }
  if (call.on_giving_up) call.on_giving_up();
  call.finish(cancelled ? grpc::Status::CANCELLED
                        : grpc::Status(grpc::StatusCode::DEADLINE_EXCEEDED,
                                       "the command was accepted but has not taken "
                                       "effect in time"));
  return true;
}

void CommandWaiter::run() {
  api::SnapshotPtr seen = source_.latest();
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (calls_.empty()) {
      changed_.wait(lock, [&] { return stopping_ || !calls_.empty(); });
      continue;
    }
    std::uint64_t step = calls_.front().from_step;
    for (const auto& call : calls_) step = std::min(step, call.from_step);
    const bool is_later = seen->step < step;
    auto deadline = steady_clock::now() + (is_later ? kLookForStep : kLook);
    for (const auto& call : calls_) deadline = std::min(deadline, call.deadline);
    lock.unlock();
    seen =
        is_later ? source_.wait_for_step(seen, step, deadline) : source_.wait_newer(seen, deadline);
    lock.lock();
    std::erase_if(calls_, [&](Call& call) { return finish_if_over(call, *seen); });
  }
}

}  // namespace aprsim::grpc_server
