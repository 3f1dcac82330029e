#include "world/robot/controller/plan_queue.hpp"

#include <utility>

namespace aprsim::robot {

void PlanQueue::begin(std::shared_ptr<PlanJob> job, PlanPrefetcher* prefetcher) {
  cancel();
  job_ = std::move(job);
  steps_left_ = job_->request().steps;
  // A plan without latency is made at once by its user.
  if (steps_left_ > 0 && prefetcher != nullptr) prefetcher->prefetch(job_);
}

void PlanQueue::cancel() {
  waiting_.reset();
  if (!job_) return;
  job_->cancel();
  job_.reset();
}

bool PlanQueue::waits(int latency_steps) const {
  // A plan that ends no later than a new one would is not discarded: a stream of commands would
  // otherwise never move the arm.
  return job_ && (job_->request().search || steps_left_ <= latency_steps);
}

PlanQueue PlanQueue::unmade() const {
  PlanQueue copy = *this;
  // The result of a plan follows from its request, so that a saved state need not contain it.
  if (copy.job_) copy.job_ = copy.job_->unmade();
  return copy;
}

void PlanQueue::replan(const MotionPlanner& planner, PlanPrefetcher* prefetcher) {
  if (!job_) return;
  job_ = std::make_shared<PlanJob>(planner, job_->request());
  if (prefetcher != nullptr) prefetcher->prefetch(job_);
}

std::size_t PlanQueue::bytes() const {
  const std::size_t waiting = waiting_ ? waiting_->bytes() : 0;
  if (!job_) return waiting;
  const PlanRequest& request = job_->request();
  return waiting + sizeof *job_ + request.request.bytes() +
         (request.surroundings ? request.surroundings->bytes() : 0);
}

}  // namespace aprsim::robot
