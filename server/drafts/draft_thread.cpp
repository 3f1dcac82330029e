#include "server/drafts/draft_thread.hpp"

#include <sys/resource.h>
#include <unistd.h>
#include <utility>

namespace aprsim::server {
namespace {

/// Niceness of the thread; the daemon's other threads have 0.
constexpr int kDraftNice = 10;

Error unavailable(const char* why) { return {ErrorCode::kUnavailable, "draft", why}; }

}  // namespace

DraftThread::DraftThread() {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

DraftThread::~DraftThread() { stop(); }

void DraftThread::add(Job job) {
  {
    std::unique_lock lock(mutex_);
    if (ended_ || waiting_.size() >= kMaxWaiting) {
      const char* const why = ended_ ? "the daemon ends" : "too many drafts wait; try again later";
      lock.unlock();
      return job.refuse(unavailable(why));
    }
    waiting_.push_back(std::move(job));
  }
  wake_.notify_one();
}

void DraftThread::stop() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  std::deque<Job> waiting;
  {
    const std::lock_guard lock(mutex_);
    waiting.swap(waiting_);
  }
  for (const Job& job : waiting) job.refuse(unavailable("the daemon ends"));
}

void DraftThread::run(const std::stop_token& stop) {
  // Linux counts niceness by thread.
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kDraftNice);
  while (true) {
    Job next;
    {
      std::unique_lock lock(mutex_);
      if (!wake_.wait(lock, stop, [this] { return !waiting_.empty(); }) || stop.stop_requested()) {
        return;
      }
      next = std::move(waiting_.front());
      waiting_.pop_front();
    }
    next.run();
  }
}

}  // namespace aprsim::server
