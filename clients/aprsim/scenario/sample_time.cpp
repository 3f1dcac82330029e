#include "clients/aprsim/scenario/sample_time.hpp"

#include <algorithm>
#include <utility>

#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/scenario/sampler.hpp"

namespace aprsim::client {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kVirtualSteps = 25;  // from sample to sample, as of polls
constexpr auto kAloneTime = 20s;             // for the connections of a killed controller to end
constexpr auto kStandstill = 120s;           // without any simulated time

Failure not_going_on(const std::string& what) {
  return {FailureKind::kCheck, "time stands: " + what};
}

}  // namespace

Outcome<std::optional<v1::Snapshot>> SampleTime::pass(bool over) {
  const auto now = std::chrono::steady_clock::now();
  if (over && !home_by_) home_by_ = now + kStandstill;
  const auto deadline = home_by_.value_or(now + kStandstill);
  bool late = false;
  const auto cancelled = [&] {
    late = std::chrono::steady_clock::now() > deadline;
    if (over) watch_.listen();
    return late || interruption::noted() || watch_.prick_up() ||
           (over && watch_.controller_has_ended());
  };
  // Only one request may be open at once: the earlier one comes first.
  while (goal_) {
    auto snapshot = read();
    if (!snapshot) return tl::unexpected(snapshot.error());
    if (!goal_) return std::optional(std::move(*snapshot));
    if (cancelled()) break;
    interruption::sleep_until(std::chrono::steady_clock::now() + 2ms);
  }
  Outcome<std::optional<v1::Snapshot>> passed;
  // Without other pacers the answer comes before anything could be heard in between.
  const bool has_ended = over && cancelled();
  if (!goal_ && !has_ended) passed = cell_.step_and_read(kVirtualSteps, kSampledFields, cancelled);
  if (late && over) return failed(FailureKind::kCheck, "the controller does not end after the run");
  if (late) return tl::unexpected(not_going_on("the controller neither polls nor ends"));
  return passed;
}

Outcome<void> SampleTime::pass_until_alone(std::uint64_t now,
                                           const std::vector<std::string>& roles) {
  const auto deadline = std::chrono::steady_clock::now() + kAloneTime;
  while (std::chrono::steady_clock::now() < deadline && !interruption::noted()) {
    if (const auto asked = request(now, 50ms); !asked) return tl::unexpected(asked.error());
    const auto snapshot = read();
    if (!snapshot) return tl::unexpected(snapshot.error());
    now = snapshot->step();
    const auto& awaited = snapshot->virtual_time().awaited();
    const auto is_awaited = [&](const std::string& role) {
      return !role.starts_with("crcl.") || std::ranges::find(awaited, role) != awaited.end();
    };
    if (std::ranges::all_of(roles, is_awaited)) return {};
    interruption::sleep_until(std::chrono::steady_clock::now() + 5ms);
  }
  return failed(FailureKind::kCheck, "the killed controller's connections do not end");
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
    // Or it has been heard of since, and only one may ask at once.
    if (passed.error().kind != FailureKind::kRefused) return tl::unexpected(passed.error());
    goal_ = now.step() + kVirtualSteps;
  }
  return passed && *passed ? std::move(**passed) : std::move(now);
}

}  // namespace aprsim::client
