#include "server/operations/memory_guard.hpp"

#include <fstream>
#include <malloc.h>
#include <unistd.h>
#include <utility>

#include <spdlog/spdlog.h>

namespace aprsim::server {
namespace {

constexpr std::chrono::seconds kPeriod{2};
/// Parts of the limit: above kHigh memory is freed; below kLow the next warning may come.
constexpr double kHigh = 0.92, kLow = 0.8;

}  // namespace

std::uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t all = 0, resident = 0;
  if (!(file >> all >> resident)) return 0;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

MemoryGuard::MemoryGuard(std::uint64_t limit_bytes, std::function<void()> relieve,
                         std::function<std::uint64_t()> resident)
    : limit_(limit_bytes), relieve_(std::move(relieve)), resident_(std::move(resident)) {}

void MemoryGuard::check(Clock::time_point now) {
  if (acted_ && now - *acted_ < kPeriod) return;
  const auto part = [this](double of) {
    return static_cast<std::uint64_t>(of * static_cast<double>(limit_));
  };
  const std::uint64_t before = resident_();
  if (before < part(kLow)) reported_ = false;
  if (before < part(kHigh)) return;
  acted_ = now;
  ::malloc_trim(0);
  if (resident_() < part(kHigh)) return;
  relieve_();
  ::malloc_trim(0);
  if (std::exchange(reported_, true)) return;
  spdlog::warn(
      "memory: {} MB are in use, the limit is {} (memory.max_mb); half of the history and "
      "of the journal in memory is dropped",
      before >> 20U, limit_ >> 20U);
}

}  // namespace aprsim::server
