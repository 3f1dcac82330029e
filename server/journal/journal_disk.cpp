#include "server/journal/journal_disk.hpp"

#include <ctime>
#include <string_view>
#include <unistd.h>
#include <utility>

#include <spdlog/spdlog.h>

#include "proto/journal/frames.hpp"
#include "server/journal/record_message.hpp"
#include "server/journal/utf8_strings.hpp"

namespace aprsim::server::journal {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::chrono::seconds kRetry{1};

/// The time and the run, so that no two runs have the same.
std::string stamp_of(const v1::JournalHeader& header) {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y%m%dT%H%M%SZ-", &utc);
  return text + (header.run_id().empty() ? std::to_string(::getpid()) : header.run_id());
}

void log(const Missing& gap) {
  spdlog::warn("journal: {} records are missing, {} of them commands: {}", gap.records,
               gap.commands, gap.reason);
}

std::string frame_of(const Missing& gap) {
  v1::JournalRecord record;
  write_message(gap, record);
  aprsim::journal::FrameEncoder encoder;
  encoder.add(record);
  return encoder.take();
}

}  // namespace

std::string header_bytes(const v1::JournalHeader& header, std::uint32_t part) {
  v1::JournalRecord record;
  write_time(std::chrono::system_clock::now(), *record.mutable_wall_time());
  *record.mutable_header() = header;
  record.mutable_header()->set_part(part);
  make_utf8(record);
  aprsim::journal::FrameEncoder encoder;
  encoder.add(record);
  return std::string(aprsim::journal::kMagic) + encoder.take();
}

JournalDisk::JournalDisk(std::string place, std::uint64_t max_file_bytes,
                         const v1::JournalHeader& header, std::size_t max_waiting_bytes)
    : files_(std::move(place), stamp_of(header), max_file_bytes),
      header_(header),
      max_waiting_bytes_(max_waiting_bytes) {}

void JournalDisk::append(const Frame& frame) {
  const bool next = frame.begins && waiting_.empty() && files_.full();
  if (next ? !open_next() : !files_.is_open()) return count_missing(frame.held, last_error_);
  if (waiting_bytes_ + frame.bytes->size() > max_waiting_bytes_) {
    return count_missing(frame.held, files_.file() + ": its reader does not keep up");
  }
  if (missing_.any()) record_gap();
  wait(frame.bytes, frame.records, frame.held);
  if (frame.begins) wants_beginning_ = false;
  write_waiting();
}

void JournalDisk::write_waiting() {
  end_with_gap();
  while (!waiting_.empty()) {
    Waiting& first = waiting_.front();
    const auto taken = files_.append(std::string_view(*first.bytes).substr(first.done));
    if (!taken) return failed(taken.error().message);
    first.done += *taken;
    if (first.done < first.bytes->size()) return;
    stats_.records += first.records;
    stats_.bytes += first.bytes->size();
    waiting_bytes_ -= first.bytes->size();
    waiting_.pop_front();
  }
}

void JournalDisk::finish(SteadyClock::time_point deadline) {
  for (write_waiting(); !waiting_.empty(); write_waiting()) {
    const auto left = deadline - SteadyClock::now();
    if (left <= left.zero() ||
        !files_.wait_writable(std::chrono::ceil<std::chrono::milliseconds>(left))) {
      spdlog::warn("journal: {}: its reader has not accepted its end", files_.file());
      break;
    }
  }
  if (missing_.any()) log(missing_);
  files_.close();
}

bool JournalDisk::wants_beginning() const {
  return (wants_beginning_ || !files_.is_open()) && SteadyClock::now() >= retry_at_;
}

bool JournalDisk::open_next() {
  if (SteadyClock::now() < retry_at_) return false;
  if (auto opened = files_.open_next(); !opened) {
    failed(opened.error().message);
    return false;
  }
  const bool again = !last_error_.empty();
  wait(std::make_shared<const std::string>(header_bytes(header_, files_.part() + 1)), 1, {});
  write_waiting();
  if (!files_.is_open()) return false;
  files_.begun();
  ended_with_ = 0;
  if (again) spdlog::info("journal: continues in {}", files_.file());
  last_error_.clear();
  return true;
}

void JournalDisk::wait(FrameBytes bytes, std::uint64_t records, const Missing& held,
                       std::uint64_t reported) {
  waiting_bytes_ += bytes->size();
  waiting_.push_back({std::move(bytes), records, held, reported, 0});
}

void JournalDisk::record_gap() {
  const Missing gap = std::exchange(missing_, {});
  // If the gap is dropped as well, its records are missing again.
  wait(std::make_shared<const std::string>(frame_of(gap)), 1, gap, gap.records);
  log(gap);
}

/// Keeps the gap at the end of the given-up file up to date while no further file can be opened.
void JournalDisk::end_with_gap() {
  if (!files_.gave_up() || missing_.records == ended_with_) return;
  if (files_.end_with(frame_of(missing_))) ended_with_ = missing_.records;
}

void JournalDisk::count_missing(const Missing& held, const std::string& why, std::uint64_t known) {
  wants_beginning_ = true;
  if (!held.any()) return;
  // Log it now: a stalled reader may never accept the gap record.
  if (!missing_.any()) {
    if (why != last_error_) spdlog::warn("journal: {}: records are missing from now on", why);
    if (known == 0) ++stats_.gaps;
  }
  stats_.missing += held.records - known;
  Missing lost = held;
  lost.reason = why;
  missing_.add(lost);
}

/// Drops all waiting frames; the next frame with a checkpoint opens another file if there is room.
void JournalDisk::failed(const std::string& why) {
  if (why != last_error_) spdlog::error("journal: {}: records are missing from now on", why);
  last_error_ = why;
  for (const Waiting& waiting : std::exchange(waiting_, {})) {
    count_missing(waiting.held, why, waiting.reported);
  }
  waiting_bytes_ = 0;
  wants_beginning_ = true;
  files_.give_up();
  end_with_gap();
  retry_at_ = SteadyClock::now() + kRetry;
}

}  // namespace aprsim::server::journal
