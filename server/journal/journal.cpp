#include "server/journal/journal.hpp"

#include <exception>
#include <new>
#include <type_traits>
#include <utility>
#include <variant>

#include <spdlog/spdlog.h>

#include "server/journal/record_message.hpp"
#include "server/journal/utf8_strings.hpp"

namespace aprsim::server::journal {
namespace {

using SteadyClock = std::chrono::steady_clock;

/// Period of emptying the queues: they stay short, and their memory is reused while it is in the
/// processor's cache.
constexpr std::chrono::milliseconds kTake{50};
/// Wall time of a frame: longer frames compress better.
constexpr std::chrono::milliseconds kFlush{500};
constexpr std::chrono::milliseconds kStep{1};  ///< step of the simulation

std::uint64_t steps_of(std::chrono::nanoseconds time) {
  return time.count() <= 0 ? 0 : static_cast<std::uint64_t>(time / kStep);
}

/// Time of a record that decides the run; null for the others.
const world::RunTime* time_of(const Entry& entry) {
  return std::visit(
      [](const auto& what) -> const world::RunTime* {
        using What = std::decay_t<decltype(what)>;
        if constexpr (std::is_same_v<What, protocols::WireRecord> ||
                      std::is_same_v<What, api::CellEventPtr> || std::is_same_v<What, Refused>) {
          return nullptr;
        } else {
          return &what.time;
        }
      },
      entry.what);
}

}  // namespace

Journal::Journal(JournalOptions options)
    : options_(std::move(options)),
      authoritative_(options_.max_queue_bytes),
      informational_(options_.max_queue_bytes),
      scenes_(options_.header, seal_),
      ring_(steps_of(options_.memory_span), options_.max_memory_bytes) {
  if (!options_.place.empty()) {
    disk_.emplace(options_.place, options_.max_file_bytes, options_.header,
                  options_.max_waiting_bytes);
    claimed_ = disk_->claim();
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

Journal::~Journal() { finish(); }

void Journal::finish() {
  const std::lock_guard lock(finish_mutex_);
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

// ---- records from other threads

template <typename Make>
void Journal::push(RecordQueue& queue, const Make& make, WallTime wall) {
  auto pushed = RecordQueue::Pushed::kMissing;
  try {
    pushed = queue.push({wall, make()});
  } catch (const std::bad_alloc&) {
    queue.lose({1, &queue == &authoritative_ ? 1U : 0U, wall, wall, {}});
  }
  if (pushed == RecordQueue::Pushed::kTaken) return;
  if (pushed == RecordQueue::Pushed::kMissing && &queue == &authoritative_)
    wants_checkpoint_ = true;
  wake_writer();
}

void Journal::wake_writer() {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(woken_, true)) return;
  }
  wake_.notify_one();
}

void Journal::began(world::RunTime time, std::uint64_t seed, const std::string* loaded,
                    const std::shared_ptr<const scene::Scene>& scene) {
  push(authoritative_, [&] {
    return EpochBegun{
        time, seed, loaded == nullptr ? std::nullopt : std::optional<std::string>(*loaded), scene};
  });
}

void Journal::applied(world::RunTime time, const world::QueuedCommand& command,
                      const Error* failure) {
  ++sequence_;
  push(authoritative_, [&] {
    return CommandApplied{time, sequence_, command,
                          failure == nullptr ? std::string() : failure->message};
  });
}

void Journal::sampled(world::RunTime time, world::StateSample sample) {
  push(authoritative_, [&] { return StateSampled{time, std::move(sample)}; });
}

void Journal::saved(world::RunTime time, std::uint64_t hash,
                    std::shared_ptr<const world::WorldState> state) {
  wants_checkpoint_ = false;
  push(authoritative_, [&] { return StateSaved{time, hash, std::move(state)}; });
}

void Journal::happened(const api::CellEventPtr& event) {
  push(informational_, [&] { return event; });
}

void Journal::stopped(world::RunTime time, const std::string& why) {
  push(authoritative_, [&] { return WorldStopped{time, why}; });
}

void Journal::record(protocols::WireRecord record) {
  const WallTime wall = record.wall;
  push(
      informational_, [&] { return std::move(record); }, wall);
}

void Journal::refused(const api::Snapshot& seen, std::string_view listener, std::string_view what) {
  push(informational_, [&] {
    return Refused{{seen.epoch, seen.step}, seen.time, std::string(listener), std::string(what)};
  });
}

void Journal::take_incident(std::chrono::nanoseconds last, Done done) {
  bool closed = false;
  {
    const std::lock_guard lock(mutex_);
    closed = closed_;
    if (!closed) wanted_.push_back({last, std::move(done)});
  }
  if (!closed) return wake_writer();
  done(fail(ErrorCode::kUnavailable, "journal", "the daemon stops"));
}

JournalStats Journal::stats() const {
  const std::uint64_t queued = authoritative_.bytes() + informational_.bytes();
  const std::lock_guard lock(mutex_);
  JournalStats stats = stats_;
  stats.queued_bytes = queued;
  return stats;
}

// ---- the writer

void Journal::run(const std::stop_token& stop) {
  auto flush_at = SteadyClock::now() + kFlush;
  while (!stop.stop_requested()) {
    bool whole = false;
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, stop, kTake, [this] { return woken_; });
      whole = std::exchange(woken_, false);
    }
    const auto now = SteadyClock::now();
    whole = whole || now >= flush_at;
    if (whole) flush_at = now + kFlush;
    turn(whole, false);
  }
  turn(true, true);
  if (disk_) disk_->finish(SteadyClock::now() + kFlush);
}

void Journal::turn(bool whole, bool ending) {
  std::vector<Wanted> wanted;
  {
    const std::lock_guard lock(mutex_);
    wanted.swap(wanted_);
    closed_ = ending;
  }
  if (drops_half_.exchange(false)) ring_.drop_older_half();
  write_taken(whole || !wanted.empty(), ending);
  for (const Wanted& want : wanted) {
    want.done(ending ? Result<protocols::Incident>(
                           fail(ErrorCode::kUnavailable, "journal", "the daemon stops"))
                     : incident(want.last));
  }
  JournalStats stats = disk_ ? disk_->stats() : JournalStats{};
  stats.gaps += gaps_;
  stats.missing += missing_records_;
  stats.memory_bytes = ring_.bytes();
  const std::lock_guard lock(mutex_);
  stats_ = stats;
}

v1::JournalRecord Journal::end_record() const {
  v1::JournalRecord record;
  write_time(std::chrono::system_clock::now(), *record.mutable_wall_time());
  auto& time = *record.mutable_end()->mutable_time();
  time.set_epoch(latest_.epoch);
  time.set_step(latest_.step);
  return record;
}

void Journal::write_taken(bool whole, bool ending) try {
  add_taken();
  if (ending && encoder_.pending() + ring_.bytes() > 0) {
    encoder_.add(end_record());
    ++next_.records;
  }
  if (whole) flush();
  if (disk_) disk_->write_waiting();
  // Records that are in no frame yet may hold the checkpoint that is wanted.
  if (!whole) return;
  if (ring_.wants_beginning() || (disk_ && disk_->wants_beginning())) wants_checkpoint_ = true;
} catch (const std::bad_alloc&) {
  drop_taken("no memory");
}

void Journal::add_taken() {
  // The informational queue first, so that the records that caused a reply come with it.
  informational_.take(taken_informational_);
  authoritative_.take(taken_authoritative_);
  auto& authoritative = taken_authoritative_.entries;
  auto& informational = taken_informational_.entries;
  while (!authoritative.empty() || !informational.empty()) {
    const bool decides =
        informational.empty() ||
        (!authoritative.empty() && authoritative.front().wall <= informational.front().wall);
    auto& next = decides ? authoritative : informational;
    add(next.front());
    next.pop_front();
  }
  for (RecordQueue::Taken* taken : {&taken_authoritative_, &taken_informational_}) {
    if (!taken->missing.any()) continue;
    taken->missing.reason = "the writer could not keep up";
    record_gap(std::exchange(taken->missing, {}));
  }
}

/// Drops the records that are in no frame yet; the next turn records their gap.
void Journal::drop_taken(const std::string& why) {
  for (RecordQueue::Taken* taken : {&taken_authoritative_, &taken_informational_}) {
    Missing lost = std::exchange(taken->missing, {});
    for (const Entry& entry : taken->entries) lost.add(entry.missing());
    taken->entries.clear();
    lost.reason = why;
    (taken == &taken_authoritative_ ? authoritative_ : informational_).lose(lost);
  }
  wants_checkpoint_ = true;
}

void Journal::add(const Entry& entry) {
  follow_clock(entry);
  const bool saved = std::holds_alternative<StateSaved>(entry.what);
  if (saved || std::holds_alternative<EpochBegun>(entry.what)) {
    // A reader can begin here; an epoch and its state stay in one frame.
    const bool behind_epoch = saved && next_.begins && next_.records == 1;
    if (!behind_epoch) flush();
    next_.begins = true;
  }
  v1::JournalRecord record;
  try {
    write_message(entry, record);
    scenes_.write(entry, record);
    make_utf8(record);
    encoder_.add(record);
  } catch (const std::exception& failure) {
    return record_gap(entry.missing(failure.what()));
  }
  ++next_.records;
  next_.held.add(entry.missing());
  if (encoder_.pending() >= aprsim::journal::kFrameBytes) flush();
}

void Journal::follow_clock(const Entry& entry) {
  const world::RunTime* time = time_of(entry);
  if (time == nullptr) return;
  if (time->epoch == latest_.epoch && time->step > latest_.step) {
    clock_ += time->step - latest_.step;
  }
  latest_ = *time;
  if (next_.records == 0) next_.clock = clock_;
}

void Journal::record_gap(const Missing& gap) {
  v1::JournalRecord record;
  write_message(gap, record);
  encoder_.add(record);
  ++next_.records;
  next_.held.add(gap);
  if (gap.commands > 0) wants_checkpoint_ = true;
  spdlog::warn("journal: {} records are missing, {} of them commands: {}", gap.records,
               gap.commands, gap.reason);
  ++gaps_;
  missing_records_ += gap.records;
}

void Journal::flush() {
  Frame frame = std::exchange(next_, {.bytes = nullptr, .held = {}, .clock = clock_});
  if (frame.records == 0) return;
  try {
    frame.bytes = std::make_shared<const std::string>(encoder_.take());
    ring_.add(frame);
    if (disk_) disk_->append(frame);
  } catch (const std::exception& failure) {
    frame.held.reason = failure.what();
    record_gap(frame.held);
  }
}

Result<protocols::Incident> Journal::incident(std::chrono::nanoseconds last) const try {
  protocols::Incident incident;
  auto frames = ring_.last(steps_of(last), clock_);
  if (frames.empty()) {
    return fail(ErrorCode::kFailedPrecondition, "journal",
                "nothing of the run is kept in memory (journal.memory_mb)");
  }
  incident.name = "aprsim-" + options_.header.run_id() + "-epoch" + std::to_string(latest_.epoch) +
                  "-step" + std::to_string(latest_.step) + ".journal";
  incident.pieces.push_back(std::make_shared<const std::string>(header_bytes(options_.header, 1)));
  incident.pieces.insert(incident.pieces.end(), frames.begin(), frames.end());
  // Marks the file as complete: an incident that was cut off on its way has no such end.
  aprsim::journal::FrameEncoder encoder;
  encoder.add(end_record());
  incident.pieces.push_back(std::make_shared<const std::string>(encoder.take()));
  return incident;
} catch (const std::bad_alloc&) {
  return fail(ErrorCode::kUnavailable, "journal", "there is no memory for it");
}

}  // namespace aprsim::server::journal
