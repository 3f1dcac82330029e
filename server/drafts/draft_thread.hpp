#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "world/base/result.hpp"

namespace aprsim::server {

/// A thread of low priority for work that pages request, with a bounded queue. Thread: any.
class DraftThread {
 public:
  static constexpr std::size_t kMaxWaiting = 8;

  struct Job {
    std::function<void()> run;                       ///< called on the thread
    std::function<void(const Error& error)> refuse;  ///< called in its place, on any thread
  };

  DraftThread();
  ~DraftThread();
  DraftThread(const DraftThread&) = delete;
  DraftThread& operator=(const DraftThread&) = delete;

  /// Refuses the job with kUnavailable when too many wait or after stop().
  void add(Job job);
  /// Ends the present job and refuses what waits and all later jobs.
  void stop();

 private:
  void run(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::deque<Job> waiting_;
  bool ended_ = false;
  std::jthread thread_;
};

}  // namespace aprsim::server
