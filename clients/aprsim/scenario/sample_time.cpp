#include "clients/aprsim/scenario/sample_time.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/scenario/sampler.hpp"

namespace aprsim::client {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kVirtualSteps = 25;  // from sample to sample, as between polls

}  // namespace

Outcome<std::optional<v1::Snapshot>> SampleTime::pass(bool over) {
  const auto now = std::chrono::steady_clock::now();
  if (over && !home_by_) home_by_ = now + patience_;
  const auto deadline = home_by_.value_or(now + patience_);
  bool late = false;
  const auto cancelled = [&] {
    late = std::chrono::steady_clock::now() > deadline;
    if (over) watch_.listen();
    return late || interruption::requested() || watch_.read_ahead() ||
           (over && watch_.controller_has_ended());
  };
  // Only one request may be open: the earlier one comes first.
  while (goal_) {
    auto snapshot = read();
    if (!snapshot) return tl::unexpected(snapshot.error());
    if (!goal_) return std::optional(std::move(*snapshot));
    if (cancelled()) break;
    interruption::sleep_until(std::chrono::steady_clock::now() + 2ms);
  }
  Outcome<std::optional<v1::Snapshot>> passed;
  // Without other pacers the reply arrives before any line of the controller.
  const bool has_ended = over && cancelled();
  if (!goal_ && !has_ended) passed = cell_.step_and_read(kVirtualSteps, kSampledFields, cancelled);
  if (late && over) {
    return failed(FailureKind::kCheck,
                  fmt::format("waited {} s for the controller to end after the "
                              "run",
                              patience_.count()));
  }
  if (late) return tl::unexpected(standstill());
  return passed;
}

Failure SampleTime::standstill() {
  std::string awaited;
  if (const auto snapshot = cell_.snapshot()) {
    for (const std::string& name : snapshot->virtual_time().awaited()) {
      awaited += (awaited.empty() ? "" : ", ") + name;
    }
  }
  return {
      FailureKind::kCheck,
      fmt::format("waited {} s for virtual time to advance: {}; the controller neither polls nor "
                  "ends",
                  patience_.count(),
                  awaited.empty() ? "no client is awaited" : "it waits for " + awaited)};
}

Outcome<void> SampleTime::pass_until_alone(std::uint64_t now,
                                           const std::vector<std::string>& roles) {
  const auto deadline = std::chrono::steady_clock::now() + patience_;
  std::string left;
  while (std::chrono::steady_clock::now() < deadline && !interruption::requested()) {
    if (const auto asked = request(now, 50ms); !asked) return tl::unexpected(asked.error());
    const auto snapshot = read();
    if (!snapshot) return tl::unexpected(snapshot.error());
    now = snapshot->step();
    const auto& awaited = snapshot->virtual_time().awaited();
    const auto is_awaited = [&](const std::string& role) {
      return !role.starts_with("crcl.") || std::ranges::find(awaited, role) != awaited.end();
    };
    const auto connected = std::ranges::find_if_not(roles, is_awaited);
    if (connected == roles.end()) return {};
    left = *connected;
    interruption::sleep_until(std::chrono::steady_clock::now() + 5ms);
  }
  if (interruption::requested()) return failed(FailureKind::kInterrupted, "interrupted");
  return failed(FailureKind::kCheck,
                fmt::format("waited {} s for the connection of the killed controller to {} to end",
                            patience_.count(), left));
}

Outcome<std::optional<v1::Snapshot>> SampleTime::request(std::uint64_t now,
                                                         std::chrono::milliseconds patience) {
  if (goal_) return std::nullopt;
  auto passed = cell_.step_and_read(kVirtualSteps, kSampledFields, patience);
  if (passed) return std::move(*passed);
  if (passed.error().kind != FailureKind::kTimeout) return tl::unexpected(passed.error());
  goal_ = now + kVirtualSteps;
  return std::nullopt;
}

Outcome<v1::Snapshot> SampleTime::read() {
  auto snapshot = cell_.snapshot();
  if (!snapshot || !goal_) return snapshot;
  if (snapshot->step() >= *goal_) {
    goal_.reset();
  } else if (std::ranges::count(snapshot->virtual_time().awaited(), "grpc") > 0) {
    return request_again(std::move(*snapshot));
  }
  return snapshot;
}

Outcome<v1::Snapshot> SampleTime::request_again(v1::Snapshot now) {
  goal_.reset();
  auto passed = request(now.step(), 50ms);
  if (!passed) {
    // The request may have arrived since, and only one may be open.
    if (passed.error().kind != FailureKind::kRefused) return tl::unexpected(passed.error());
    goal_ = now.step() + kVirtualSteps;
  }
  return passed && *passed ? std::move(**passed) : std::move(now);
}

}  // namespace aprsim::client
