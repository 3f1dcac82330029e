#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

#include "world/robot/planning/plan_job.hpp"

namespace aprsim::robot {

/// A thread that makes one robot's plans ahead: the latest job that was given, one at a time.
class PlanningThread final : public PlanPrefetcher {
 public:
  PlanningThread();
  ~PlanningThread() override;
  PlanningThread(const PlanningThread&) = delete;
  PlanningThread& operator=(const PlanningThread&) = delete;

  void prefetch(std::shared_ptr<PlanJob> job) override;

 private:
  void run(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any given_;
  std::shared_ptr<PlanJob> next_;
  std::jthread thread_;  // ends first
};

}  // namespace aprsim::robot
