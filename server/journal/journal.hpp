#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "aprsim/v1/journal.pb.h"
#include "proto/journal/frames.hpp"
#include "server/journal/journal_files.hpp"
#include "server/journal/journal_stats.hpp"
#include "server/journal/record_queue.hpp"
#include "world/recorder.hpp"

namespace aprsim::server::journal {

struct JournalOptions {
  std::string place;  ///< file or directory
  std::uint64_t max_file_bytes = std::uint64_t{64} << 20;
  std::size_t max_queue_bytes = std::size_t{64} << 20;
  v1::JournalHeader header;  ///< of the run; `part` is the journal's
};

/// Records a run: takes what is told of it from any thread without making it wait, and writes it
/// with a thread of its own, half a second later at the latest. What cannot be written is told as a
/// gap in the journal and in the log; a checkpoint follows it.
class Journal final : public world::Recorder {
 public:
  explicit Journal(JournalOptions options);
  /// Writes what is there, for half a second at most, unless the system does not take it.
  ~Journal() override;
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  // ---- Thread: sim
  void began(world::RunTime time, std::uint64_t seed, const std::string* loaded) override;
  void applied(world::RunTime time, const world::QueuedCommand& command,
               const Error* failure) override;
  void sampled(world::RunTime time, world::StateSample sample) override;
  void saved(world::RunTime time, std::uint64_t hash,
             std::shared_ptr<const world::WorldState> state) override;
  void stopped(world::RunTime time, const std::string& why) override;
  [[nodiscard]] bool wants_checkpoint() const override {
    return wants_checkpoint_.load(std::memory_order_relaxed);
  }

  // ---- Thread: any
  [[nodiscard]] JournalStats stats() const;

 private:
  void push(decltype(Entry::what) what);
  // ---- Thread: the writer's
  void run(const std::stop_token& stop);
  void take_over(RecordQueue::Taken& taken);
  void add(const Entry& entry);
  void add(v1::JournalRecord& record, WallTime wall, std::uint64_t commands = 0);
  void tell_gap();
  void flush();
  void put_away(const std::string& frame);
  void failed(const std::string& why);
  [[nodiscard]] bool open_next(std::chrono::steady_clock::time_point now);
  [[nodiscard]] std::string header_frame(std::uint32_t part) const;

  const JournalOptions options_;
  RecordQueue queue_;
  std::atomic<bool> wants_checkpoint_{false};
  std::uint64_t sequence_ = 0;  ///< thread: sim

  // The writer's.
  aprsim::journal::FrameEncoder encoder_;
  JournalFiles files_;
  Missing missing_;     ///< still to be told
  Missing pending_;     ///< what the next frame holds, should it fail
  bool begun_ = false;  ///< the first file or part
  std::chrono::steady_clock::time_point retry_at_{};
  std::string trouble_;  ///< that the log has told of

  mutable std::mutex kept_;  ///< of the stats
  JournalStats stats_;
  std::jthread thread_;  // ends first
};

}  // namespace aprsim::server::journal
