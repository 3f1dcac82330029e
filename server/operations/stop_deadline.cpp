#include "server/operations/stop_deadline.hpp"

#include <cstdlib>
#include <mutex>
#include <thread>
#include <unistd.h>
#include <utility>

#include <spdlog/spdlog.h>

namespace aprsim::server {

struct StopDeadline::Shared {
  std::mutex mutex;  ///< held while `finish` runs
  std::function<void()> finish;
};

StopDeadline::StopDeadline(std::function<void()> finish, std::chrono::milliseconds patience,
                           std::chrono::milliseconds last_patience)
    : shared_(std::make_shared<Shared>()) {
  shared_->finish = std::move(finish);
  // Detached: they live as long as the process.
  std::thread([patience, last_patience] {
    std::this_thread::sleep_for(patience + last_patience);
    ::_exit(EXIT_SUCCESS);
  }).detach();
  std::thread([shared = shared_, patience] {
    std::this_thread::sleep_for(patience);
    const std::lock_guard lock(shared->mutex);
    if (!shared->finish) return;
    spdlog::warn("stopping takes too long; the process ends now");
    shared->finish();
    ::_exit(EXIT_SUCCESS);
  }).detach();
}

StopDeadline::~StopDeadline() {
  const std::lock_guard lock(shared_->mutex);
  shared_->finish = nullptr;
}

}  // namespace aprsim::server
