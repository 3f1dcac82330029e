#include "server/journal/journal.hpp"

#include <condition_variable>
#include <ctime>
#include <stdexcept>
#include <utility>

#include <spdlog/spdlog.h>

#include "server/journal/command_message.hpp"
#include "world/state_bytes.hpp"

namespace aprsim::server::journal {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kFlush{500};
constexpr std::chrono::seconds kRetry{1};

void write_time(WallTime time, google::protobuf::Timestamp& message) {
  const auto since = std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch());
  message.set_seconds(since.count() / 1'000'000'000);
  message.set_nanos(static_cast<std::int32_t>(since.count() % 1'000'000'000));
}

void write_time(world::RunTime time, v1::JournalTime& message) {
  message.set_epoch(time.epoch);
  message.set_step(time.step);
}

void write(const EpochBegun& epoch, v1::JournalRecord& record) {
  auto& to = *record.mutable_epoch();
  write_time(epoch.time, *to.mutable_time());
  to.set_seed(epoch.seed);
  if (epoch.loaded) to.set_loaded_state(*epoch.loaded);
}

void write(const CommandApplied& applied, v1::JournalRecord& record) {
  auto& to = *record.mutable_command();
  write_message(applied.command.command, to);
  write_time(applied.time, *to.mutable_time());
  to.set_sequence(applied.sequence);
  to.set_ticket(applied.command.ticket);
  to.set_failure(applied.failure);
}

void write(const StateSampled& sampled, v1::JournalRecord& record) {
  auto& to = *record.mutable_state();
  write_time(sampled.time, *to.mutable_time());
  to.set_hash(sampled.sample.hash);
  for (const double angle : sampled.sample.joints_rad) to.add_joints_rad(angle);
  for (const double coordinate : sampled.sample.bodies_m) to.add_bodies_m(coordinate);
  to.set_belt_travel_m(sampled.sample.belt_travel_m);
}

void write(const StateSaved& saved, v1::JournalRecord& record) {
  auto& to = *record.mutable_checkpoint();
  write_time(saved.time, *to.mutable_time());
  to.set_state(world::to_bytes(*saved.state));
  to.set_hash(saved.hash);
}

void write(const WorldStopped& stopped, v1::JournalRecord& record) {
  auto& to = *record.mutable_event();
  to.set_epoch(stopped.time.epoch);
  to.set_step(stopped.time.step);
  to.set_kind(v1::CELL_EVENT_KIND_WORLD_STOPPED);
  to.set_text(stopped.why);
}

std::string stamp_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y%m%dT%H%M%SZ", &utc);
  return text;
}

}  // namespace

Journal::Journal(JournalOptions options)
    : options_(std::move(options)),
      queue_(options_.max_queue_bytes),
      files_(options_.place, stamp_now(), options_.max_file_bytes) {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

Journal::~Journal() {
  thread_.request_stop();
  queue_.close();
}

// ---- what is told

void Journal::push(decltype(Entry::what) what) {
  if (!queue_.push({std::chrono::system_clock::now(), std::move(what)})) {
    wants_checkpoint_ = true;
  }
}

void Journal::began(world::RunTime time, std::uint64_t seed, const std::string* loaded) {
  push(EpochBegun{time, seed,
                  loaded == nullptr ? std::nullopt : std::optional<std::string>(*loaded)});
}

void Journal::applied(world::RunTime time, const world::QueuedCommand& command,
                      const Error* failure) {
  push(CommandApplied{time, ++sequence_, command,
                      failure == nullptr ? std::string() : failure->message});
}

void Journal::sampled(world::RunTime time, world::StateSample sample) {
  push(StateSampled{time, std::move(sample)});
}

void Journal::saved(world::RunTime time, std::uint64_t hash,
                    std::shared_ptr<const world::WorldState> state) {
  wants_checkpoint_ = false;
  push(StateSaved{time, hash, std::move(state)});
}

void Journal::stopped(world::RunTime time, const std::string& why) {
  push(WorldStopped{time, why});
}

JournalStats Journal::stats() const {
  const std::lock_guard lock(kept_);
  return stats_;
}

// ---- the writer

void Journal::run(const std::stop_token& stop) {
  RecordQueue::Taken taken;
  bool ending = false;
  while (!ending) {
    ending = stop.stop_requested();
    queue_.take(taken, SteadyClock::now() + kFlush);
    take_over(taken);
    if (ending && files_.is_open()) {
      v1::JournalRecord record;
      record.mutable_end();
      add(record, std::chrono::system_clock::now());
    }
    flush();
    // Frames are half a second's, not one for each record.
    if (!ending) {
      std::mutex mutex;
      std::condition_variable_any pause;
      std::unique_lock lock(mutex);
      pause.wait_for(lock, stop, kFlush, [] { return false; });
    }
  }
}

void Journal::take_over(RecordQueue::Taken& taken) {
  for (const Entry& entry : taken.entries) {
    try {
      add(entry);
    } catch (const std::exception& failure) {
      missing_.add({1, 0, entry.wall, entry.wall, failure.what()});
    }
  }
  if (!taken.missing.any()) return;
  flush();
  taken.missing.reason = "the writer could not keep up";
  missing_.add(taken.missing);
}

void Journal::add(const Entry& entry) {
  const bool checkpoint = std::holds_alternative<StateSaved>(entry.what);
  const bool first = std::holds_alternative<EpochBegun>(entry.what) && !begun_;
  const std::uint64_t commands = std::holds_alternative<CommandApplied>(entry.what) ? 1 : 0;
  if (checkpoint || first) {
    begun_ = true;
    // Whoever reads from here on needs nothing of what was before.
    flush();
    if (files_.full() && !open_next(SteadyClock::now())) {
      missing_.add({1, 0, entry.wall, entry.wall, trouble_});
      return;
    }
  }
  if (!files_.is_open()) {
    missing_.add({1, commands, entry.wall, entry.wall, trouble_});
    wants_checkpoint_ = true;
    return;
  }
  if (missing_.any()) tell_gap();
  v1::JournalRecord record;
  std::visit([&record](const auto& what) { write(what, record); }, entry.what);
  add(record, entry.wall, commands);
  if (encoder_.pending() >= aprsim::journal::kFrameBytes) flush();
}

void Journal::add(v1::JournalRecord& record, WallTime wall, std::uint64_t commands) {
  write_time(wall, *record.mutable_wall_time());
  encoder_.add(record);
  pending_.add({1, commands, wall, wall, {}});
}

void Journal::tell_gap() {
  const Missing gap = std::exchange(missing_, {});
  v1::JournalRecord record;
  auto& to = *record.mutable_gap();
  to.set_records(gap.records);
  to.set_commands(gap.commands);
  write_time(gap.begin, *to.mutable_begin());
  write_time(gap.end, *to.mutable_end());
  to.set_reason(gap.reason);
  add(record, std::chrono::system_clock::now());
  {
    const std::lock_guard lock(kept_);
    ++stats_.gaps;
    stats_.missing += gap.records;
  }
  spdlog::warn("journal: {} records are missing, {} of them commands: {}", gap.records,
               gap.commands, gap.reason);
  wants_checkpoint_ = true;
}

void Journal::flush() {
  std::size_t bytes = 0;
  try {
    const std::string frame = encoder_.take();
    if (frame.empty()) return;
    put_away(frame);
    bytes = frame.size();
  } catch (const std::exception& failure) {
    return failed(failure.what());
  }
  const Missing held = std::exchange(pending_, {});
  const std::lock_guard lock(kept_);
  stats_.records += held.records;
  stats_.bytes += bytes;
}

void Journal::put_away(const std::string& frame) {
  if (!files_.is_open()) throw std::runtime_error(trouble_);
  if (auto done = files_.append(frame); !done) throw std::runtime_error(done.error().message);
}

/// What the frame held is missing; the next checkpoint begins another file, if there is one.
void Journal::failed(const std::string& why) {
  if (why != trouble_) spdlog::error("journal: {}", why);
  trouble_ = why;
  pending_.reason = why;
  missing_.add(std::exchange(pending_, {}));
  files_.close();
  retry_at_ = SteadyClock::now() + kRetry;
  wants_checkpoint_ = true;
}

bool Journal::open_next(SteadyClock::time_point now) {
  if (now < retry_at_) return false;
  if (auto opened = files_.open_next(header_frame(files_.part() + 1)); !opened) {
    failed(opened.error().message);
    return false;
  }
  if (!trouble_.empty()) spdlog::info("journal: goes on in {}", files_.file());
  trouble_.clear();
  return true;
}

std::string Journal::header_frame(std::uint32_t part) const {
  v1::JournalRecord record;
  write_time(std::chrono::system_clock::now(), *record.mutable_wall_time());
  *record.mutable_header() = options_.header;
  record.mutable_header()->set_part(part);
  aprsim::journal::FrameEncoder encoder;
  encoder.add(record);
  return encoder.take();
}

}  // namespace aprsim::server::journal
