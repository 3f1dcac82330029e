#include "protocols/record/connection_trace.hpp"

#include <atomic>
#include <new>
#include <utility>

namespace aprsim::protocols {
namespace {

std::uint64_t next_number() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

void set_time(WireRecord& record, const api::SnapshotSource& source) {
  record.wall = std::chrono::system_clock::now();
  const api::SnapshotPtr now = source.latest();
  record.epoch = now->epoch;
  record.step = now->step;
  record.sim_time = now->time;
}

}  // namespace

ConnectionTrace::ConnectionTrace(WireTrace* trace, const api::SnapshotSource& source, WireKind kind,
                                 std::string listener, std::string peer)
    : trace_(trace), source_(&source) {
  if (trace_ == nullptr) return;
  connection_ = std::make_shared<const WireConnection>(
      WireConnection{kind, std::move(listener), next_number(), std::move(peer)});
  record(WireContent::kOpened, {}, {});
}

ConnectionTrace::ConnectionTrace(ConnectionTrace&& other) noexcept
    : trace_(std::exchange(other.trace_, nullptr)),
      source_(other.source_),
      connection_(std::move(other.connection_)),
      first_(std::exchange(other.first_, std::nullopt)) {}

ConnectionTrace& ConnectionTrace::operator=(ConnectionTrace&& other) noexcept {
  closed({});
  trace_ = std::exchange(other.trace_, nullptr);
  source_ = other.source_;
  connection_ = std::move(other.connection_);
  first_ = std::exchange(other.first_, std::nullopt);
  return *this;
}

void ConnectionTrace::closed(std::string_view why) {
  if (trace_ == nullptr) return;
  record(WireContent::kClosed, {}, why);
  trace_ = nullptr;
}

void ConnectionTrace::received_first(std::string_view data) {
  if (trace_ == nullptr) return;
  catch_up();
  first_ = record_of(WireContent::kReceived, data, {});
}

void ConnectionTrace::catch_up() {
  if (first_) trace_->record(*std::exchange(first_, std::nullopt));
}

void ConnectionTrace::record(WireContent content, std::string_view data, std::string_view text) {
  catch_up();
  trace_->record(record_of(content, data, text));
}

WireRecord ConnectionTrace::record_of(WireContent content, std::string_view data,
                                      std::string_view text) const {
  WireRecord record{.connection = connection_, .content = content};
  try {
    record.data = data;
    record.text = text;
  } catch (const std::bad_alloc&) {
    record.data.clear();
    record.text = "no memory";  // short enough to need none
  }
  set_time(record, *source_);
  return record;
}

void record(WireTrace& trace, const api::SnapshotSource& source, WireRecord record) {
  set_time(record, source);
  trace.record(std::move(record));
}

}  // namespace aprsim::protocols
