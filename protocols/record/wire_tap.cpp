#include "protocols/record/wire_tap.hpp"

#include <algorithm>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "protocols/net/limited_log.hpp"

namespace aprsim::protocols {
namespace {

/// Memory of an event and of its entry in a queue.
std::size_t size_of(const WireEvent& event) {
  return sizeof event + 2 * sizeof(WireEventPtr) + event.source.size() + event.peer.size() +
         event.identity.size() + event.type.size() + event.state.size() + event.data.size();
}

std::span<const std::uint8_t> as_bytes(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

void WireTap::Kept::add(WireEventPtr event) {
  bytes += size_of(*event);
  events.push_back(std::move(event));
}

void WireTap::Kept::drop_oldest() {
  bytes -= size_of(*events.front());
  events.pop_front();
}

void WireTap::want_polls(bool on) {
  if (wants_polls_.exchange(on) == on || on) return;
  const std::lock_guard lock(mutex_);
  polls_ = {};
}

void WireTap::record(WireEvent event) {
  if (event.poll && !wants_polls()) return;
  const api::SnapshotPtr snapshot = source_.latest();
  event.sim_time_s = std::chrono::duration<double>(snapshot->time).count();
  event.sim_epoch = snapshot->epoch;
  event.data_bytes = event.data.size();
  if (event.data.size() > kMaxData) {
    event.data.resize(kMaxData);
    event.data.shrink_to_fit();
  }
  event.type = log_text(event.type);
  event.state = log_text(event.state);
  if (audit_ != nullptr && event.from_client && !event.poll && event.source != "page") audit(event);
  const auto shared = std::make_shared<WireEvent>(std::move(event));
  const std::lock_guard lock(mutex_);
  shared->number = ++last_number_;
  if (shared->poll) {
    polls_.add(shared);
    while (polls_.events.size() > kMaxPolls || polls_.bytes > kMaxPollBytes) polls_.drop_oldest();
    return;
  }
  Kept& kept = commands_[shared->source];
  const std::size_t before = kept.bytes;
  kept.add(shared);
  command_bytes_ += kept.bytes - before;
  give_up_commands(shared->time);
}

void WireTap::audit(const WireEvent& event) const {
  AuditRecord record{.wire = event.source,
                     .peer = event.peer,
                     .identity = event.identity.empty() ? "no credentials" : event.identity,
                     .command = event.type,
                     .request = event.data,
                     .outcome = event.state,
                     .time = event.time};
  // Modbus requests have no text, hence their bytes.
  if (event.type.empty()) {
    record.command = "write";
    record.request = fmt::format("{:02x}", fmt::join(as_bytes(event.data), ""));
  }
  audit_->write(record);
}

void WireTap::give_up_commands(std::chrono::system_clock::time_point now) {
  const auto drop = [this](Kept& kept) {
    const std::size_t before = kept.bytes;
    kept.drop_oldest();
    command_bytes_ -= before - kept.bytes;
    ++given_up_;
  };
  for (auto& [source, kept] : commands_) {
    while (kept.events.size() > kKeptAnyway && now - kept.events.front()->time > kKeep) drop(kept);
  }
  while (command_bytes_ > max_bytes_) {
    drop(std::max_element(commands_.begin(), commands_.end(), [](const auto& a, const auto& b) {
           return a.second.bytes < b.second.bytes;
         })->second);
  }
}

std::uint64_t WireTap::read(std::uint64_t from, bool with_polls, std::size_t max_bytes,
                            std::vector<WireEventPtr>& out) const {
  using At = std::deque<WireEventPtr>::const_iterator;
  const std::lock_guard lock(mutex_);
  std::vector<std::pair<At, At>> queues;
  const auto begin_at = [&](const Kept& kept) {
    const At first =
        std::lower_bound(kept.events.begin(), kept.events.end(), from,
                         [](const auto& event, auto number) { return event->number < number; });
    if (first != kept.events.end()) queues.emplace_back(first, kept.events.end());
  };
  for (const auto& [source, kept] : commands_) begin_at(kept);
  if (with_polls) begin_at(polls_);
  // Merges the sorted queues.
  for (std::size_t bytes = 0; !queues.empty();) {
    const auto next = std::min_element(
        queues.begin(), queues.end(),
        [](const auto& a, const auto& b) { return (*a.first)->number < (*b.first)->number; });
    const WireEventPtr& event = *next->first;
    bytes += size_of(*event);
    if (bytes > max_bytes && event->number != from && !out.empty()) return event->number;
    out.push_back(event);
    if (++next->first == next->second) queues.erase(next);
  }
  return last_number_ + 1;
}

std::uint64_t WireTap::given_up() const {
  const std::lock_guard lock(mutex_);
  return given_up_;
}

}  // namespace aprsim::protocols
