#include "protocols/crcl/guard_book.hpp"

#include <chrono>
#include <limits>
#include <string>

#include <spdlog/fmt/fmt.h>

#include "crcl/text.hpp"
#include "protocols/crcl/status_builder.hpp"

namespace aprsim::protocols {
namespace {

// Far beyond any motion, far within what nanoseconds can count.
constexpr std::int64_t kMaxRecheckUs = 1'000'000'000;
constexpr std::size_t kMaxLabel = 48;

std::string label_of(const crcl::Guard& guard) {
  std::string label = guard.name.value_or("");
  if (label.empty()) label = guard.sensor_id;
  if (!guard.name && guard.sub_field) label += " " + *guard.sub_field;
  return crcl::shorten(label, kMaxLabel);
}

Result<api::Guard> to_world(const crcl::Guard& guard, const SensorBoard& sensors,
                            const crcl::Units& units) {
  const Result<SensorSignal> signal = sensors.find(guard.sensor_id, guard.sub_field);
  if (!signal) return tl::unexpected(signal.error());
  const bool change = guard.limit == crcl::GuardLimit::kIncreaseOverLimit ||
                      guard.limit == crcl::GuardLimit::kDecreaseBeyondLimit;
  if (change && !(guard.limit_value > 0)) {
    return fail(ErrorCode::kInvalidArgument, "LimitValue",
                fmt::format("LimitValue {} of guard {}: must be above 0 for an increase or "
                            "decrease",
                            guard.limit_value, label_of(guard)));
  }
  const std::int64_t period_us =
      guard.recheck_time_us.value_or(api::kGuardRecheck / std::chrono::microseconds(1));
  if (period_us < 0 || period_us > kMaxRecheckUs) {
    return fail(ErrorCode::kInvalidArgument, "RecheckTimeMicroSeconds",
                fmt::format("RecheckTimeMicroSeconds {} of guard {}: must be within 0 and {}",
                            period_us, label_of(guard), kMaxRecheckUs));
  }
  api::Guard out;
  out.signal = signal->signal;
  out.limit = static_cast<api::GuardLimit>(guard.limit);
  out.value = in_si(guard.limit_value, signal->quantity, units);
  out.recheck = std::chrono::microseconds(period_us);
  out.require_trigger = guard.require_trigger.value_or(false);
  out.error_on_trigger = guard.error_on_trigger.value_or(false);
  out.label = label_of(guard);
  return out;
}

}  // namespace

Result<std::vector<api::Guard>> GuardBook::to_world(const std::vector<crcl::Guard>& guards,
                                                    const SensorBoard& sensors,
                                                    const crcl::Units& units) {
  if (guards.size() > api::kMaxGuards) {
    return fail(ErrorCode::kInvalidArgument, "Guard",
                fmt::format("{} guards, must be at most {}", guards.size(), api::kMaxGuards));
  }
  std::vector<api::Guard> out;
  for (const crcl::Guard& guard : guards) {
    Result<api::Guard> converted = protocols::to_world(guard, sensors, units);
    if (!converted) return tl::unexpected(converted.error());
    out.push_back(std::move(*converted));
  }
  return out;
}

void GuardBook::remember(api::Ticket ticket, const std::vector<crcl::Guard>& guards,
                         const SensorBoard& sensors, const crcl::Units& units) {
  if (guards.empty()) return;
  ticket_ = ticket;
  entries_.clear();
  for (const crcl::Guard& guard : guards) {
    const Result<SensorSignal> signal = sensors.find(guard.sensor_id, guard.sub_field);
    Entry& entry = entries_.emplace_back(Entry{guard, signal ? signal->quantity : Quantity::kNone});
    entry.guard.limit_value = in_si(guard.limit_value, entry.quantity, units);
    entry.guard.check_count.reset();
    entry.guard.last_check_time.reset();
    entry.guard.last_check_value.reset();
  }
}

crcl::GuardsStatuses GuardBook::statuses(const api::GuardsSnapshot& seen, std::int64_t start_ms,
                                         const crcl::Units& units) const {
  const bool taken = seen.ticket == ticket_;
  crcl::GuardsStatuses out;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Quantity quantity = entries_[i].quantity;
    crcl::Guard& guard = out.guards.emplace_back(entries_[i].guard);
    guard.limit_value = in_unit(guard.limit_value, quantity, units);
    if (!taken || i >= seen.count || seen.guards[i].checks == 0) continue;
    guard.check_count = static_cast<std::int64_t>(seen.guards[i].checks);
    guard.last_check_time = start_ms + seen.guards[i].last_check / std::chrono::milliseconds(1);
    guard.last_check_value = in_unit(seen.guards[i].last_value, quantity, units);
  }
  out.trigger_count = static_cast<std::int32_t>(
      std::min<std::uint32_t>(seen.triggers, std::numeric_limits<std::int32_t>::max()));
  out.trigger_stop_time_us = seen.stop_time / std::chrono::microseconds(1);
  if (seen.triggers > 0) {
    const bool known = taken && seen.trigger_guard < entries_.size();
    const Quantity quantity = known ? entries_[seen.trigger_guard].quantity : Quantity::kNone;
    out.trigger_value = in_unit(seen.trigger_value, quantity, units);
    out.trigger_pose = pose_in(seen.trigger_X_RT, units.length);
  }
  return out;
}

}  // namespace aprsim::protocols
