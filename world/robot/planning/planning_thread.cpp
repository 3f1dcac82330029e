#include "world/robot/planning/planning_thread.hpp"

#include <utility>

namespace aprsim::robot {

PlanningThread::PlanningThread() {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

PlanningThread::~PlanningThread() = default;

void PlanningThread::prefetch(std::shared_ptr<PlanJob> job) {
  {
    const std::lock_guard lock(mutex_);
    next_.swap(job);
  }
  given_.notify_one();
  // `job`, which has not begun, is let go here, outside the lock.
}

void PlanningThread::run(const std::stop_token& stop) {
  while (true) {
    std::shared_ptr<PlanJob> job;
    {
      std::unique_lock lock(mutex_);
      if (!given_.wait(lock, stop, [this] { return next_ != nullptr; })) return;
      job = std::move(next_);
      next_ = nullptr;
    }
    try {
      job->get();
    } catch (...) {
      // Out of memory: the simulation asks again when it needs the plan, and has the exception.
    }
  }
}

}  // namespace aprsim::robot
