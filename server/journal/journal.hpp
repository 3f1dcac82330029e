#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "aprsim/v1/journal.pb.h"
#include "proto/journal/frames.hpp"
#include "protocols/ports/incident_source.hpp"
#include "protocols/ports/wire_trace.hpp"
#include "server/journal/frame_ring.hpp"
#include "server/journal/journal_disk.hpp"
#include "server/journal/journal_stats.hpp"
#include "server/journal/record_queue.hpp"
#include "server/journal/scene_writer.hpp"
#include "world/runtime/record/recorder.hpp"

namespace aprsim::server::journal {

struct JournalOptions {
  std::string place;  ///< file or directory; empty = it is kept in memory only
  std::uint64_t max_file_bytes = std::uint64_t{64} << 20;
  std::chrono::minutes memory_span{10};                   ///< simulated time that is kept in memory
  std::size_t max_memory_bytes = std::size_t{256} << 20;  ///< limit of that memory
  /// Limit of each of the two queues: of records that decide the run, and of the others.
  std::size_t max_queue_bytes = std::size_t{64} << 20;
  /// Limit of frames that a slow reader of the journal has not accepted.
  std::size_t max_waiting_bytes = std::size_t{16} << 20;
  v1::JournalHeader header;  ///< of the run; `part` is the journal's
};

/// Records a run. It accepts records from any thread without blocking it. A thread of its own keeps
/// the latest ones in memory and writes all of them to files within little more than half a second.
/// Records that find no room leave a gap, which journal and log report; a checkpoint follows it.
class Journal final : public world::Recorder,
                      public protocols::WireTrace,
                      public protocols::IncidentSource {
 public:
  explicit Journal(JournalOptions options);
  /// As finish().
  ~Journal() override;
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Error: the place cannot be recorded in, as it was found at construction. The journal tries
  /// again while it runs.
  [[nodiscard]] const Result<void>& claimed() const { return claimed_; }

  // ---- Thread: sim
  void began(world::RunTime time, std::uint64_t seed, const std::string* loaded,
             const std::shared_ptr<const scene::Scene>& scene) override;
  void applied(world::RunTime time, const world::QueuedCommand& command,
               const Error* failure) override;
  void sampled(world::RunTime time, world::StateSample sample) override;
  void saved(world::RunTime time, std::uint64_t hash,
             std::shared_ptr<const world::WorldState> state) override;
  void happened(const api::CellEventPtr& event) override;
  void stopped(world::RunTime time, const std::string& why) override;
  [[nodiscard]] bool wants_checkpoint() const override {
    return wants_checkpoint_.load(std::memory_order_relaxed);
  }

  // ---- Thread: any
  void record(protocols::WireRecord record) override;
  /// Records what a listener has refused before the cell saw it, with the latest snapshot of that
  /// listener.
  void refused(const api::Snapshot& seen, std::string_view listener, std::string_view what);
  void take_incident(std::chrono::nanoseconds last, Done done) override;
  [[nodiscard]] JournalStats stats() const;
  /// Makes the writer drop the older half of what is kept in memory.
  void drop_older_half() { drops_half_ = true; }
  /// Writes the rest, waits half a second for a slow reader at most, and ends; later records are
  /// dropped. A second call does nothing. Thread: not the simulation's.
  void finish();

 private:
  struct Wanted {
    std::chrono::nanoseconds last{};
    Done done;
  };

  /// Queues what `make` returns; without memory the record counts as missing.
  template <typename Make>
  void push(RecordQueue& queue, const Make& make, WallTime wall = std::chrono::system_clock::now());
  void wake_writer();
  // ---- Thread: the writer's
  void run(const std::stop_token& stop);
  /// `whole`: pending records become a frame now.
  void turn(bool whole, bool ending);
  void write_taken(bool whole, bool ending);
  void add_taken();
  void drop_taken(const std::string& why);
  void add(const Entry& entry);
  void record_gap(const Missing& gap);
  void follow_clock(const Entry& entry);
  void flush();
  /// The record that ends a file that is complete.
  [[nodiscard]] v1::JournalRecord end_record() const;
  [[nodiscard]] Result<protocols::Incident> incident(std::chrono::nanoseconds last) const;

  const JournalOptions options_;
  // Records that decide the run have a queue of their own: a flood of wire records and events
  // cannot displace one.
  RecordQueue authoritative_, informational_;
  std::atomic<bool> wants_checkpoint_{false}, drops_half_{false};
  std::uint64_t sequence_ = 0;  ///< of commands; thread: sim

  // Members of the writer thread.
  RecordQueue::Taken taken_authoritative_, taken_informational_;
  aprsim::journal::FrameEncoder encoder_;
  Frame next_;  ///< describes the records in the encoder
  const StateSeal seal_{StateSeal::folder()};
  SceneWriter scenes_;
  FrameRing ring_;
  std::optional<JournalDisk> disk_;
  Result<void> claimed_;
  world::RunTime latest_;
  std::uint64_t clock_ = 0;                       ///< steps of all epochs
  std::uint64_t gaps_ = 0, missing_records_ = 0;  ///< gaps of the queues

  mutable std::mutex mutex_;  ///< guards what follows; never held during a write
  std::condition_variable_any wake_;
  bool woken_ = false, closed_ = false;
  std::vector<Wanted> wanted_;
  JournalStats stats_;
  std::mutex finish_mutex_;
  std::jthread thread_;  // ends first
};

}  // namespace aprsim::server::journal
