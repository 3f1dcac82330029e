#include "server/operations/logging.hpp"

#include <chrono>
#include <memory>
#include <unistd.h>

#include <spdlog/async.h>
#include <spdlog/spdlog.h>

#include "server/operations/log_sink.hpp"

namespace aprsim::server {
namespace {

constexpr std::size_t kLines = 8192;
/// Time for a stalled reader at the end.
constexpr std::chrono::milliseconds kPatience{500};

}  // namespace

Logging::Logging(const std::string& level) {
  spdlog::init_thread_pool(kLines, 1);
  // The pool's thread calls the sink, hence the pool exists.
  auto* pool = spdlog::thread_pool().get();
  sink_ = std::make_shared<LogSink>(STDERR_FILENO, [pool] { return pool->overrun_counter(); });
  auto logger = std::make_shared<spdlog::async_logger>(
      "aprsimd", sink_, spdlog::thread_pool(), spdlog::async_overflow_policy::overrun_oldest);
  logger->set_level(spdlog::level::from_str(level));
  logger->set_pattern("%Y-%m-%dT%H:%M:%S.%e %^%l%$ %v");
  spdlog::set_default_logger(std::move(logger));
}

Logging::~Logging() {
  sink_->give_up_at(LogSink::Clock::now() + kPatience);
  spdlog::shutdown();
}

}  // namespace aprsim::server
