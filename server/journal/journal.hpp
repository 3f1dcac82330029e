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
  std::chrono::minutes memory_span{10};  ///< simulated; so much of the latest is kept in memory
  std::size_t max_memory_bytes = std::size_t{256} << 20;  ///< of that
  /// Of what is to be written; of what the simulation tells, and as much of what the wires do.
  std::size_t max_queue_bytes = std::size_t{64} << 20;
  v1::JournalHeader header;  ///< of the run; `part` is the journal's
};

/// Records a run: takes what is told of it from any thread without making it wait, and with a
/// thread of its own keeps the latest in memory and writes all to the files, little more than half
/// a second later. What finds no room is told as a gap in the journal and in the log; a checkpoint
/// follows it.
class Journal final : public world::Recorder,
                      public protocols::WireTrace,
                      public protocols::IncidentSource {
 public:
  explicit Journal(JournalOptions options);
  /// Writes what is there; half a second for a reader that is slow.
  ~Journal() override;
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

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
  void note(protocols::WireRecord record) override;
  /// What a listener has refused before the cell saw it, and the latest that it had seen.
  void refused(const api::Snapshot& seen, std::string_view listener, std::string_view what);
  void take_incident(std::chrono::nanoseconds last, Done done) override;
  [[nodiscard]] JournalStats stats() const;

 private:
  struct Wanted {
    std::chrono::nanoseconds last{};
    Done done;
  };

  /// `make` gives what is told; where there is no memory for it, it is missing.
  template <typename Make>
  void push(RecordQueue& queue, const Make& make, WallTime wall = std::chrono::system_clock::now());
  void hurry();
  // ---- Thread: the writer's
  void run(const std::stop_token& stop);
  /// `whole`: all of it becomes a frame now.
  void turn(bool whole, bool ending);
  void write_taken(bool whole, bool ending);
  void add_taken();
  void lose_taken(const std::string& why);
  void add(const Entry& entry);
  void tell_gap(const Missing& gap);
  void follow_clock(const Entry& entry);
  void flush();
  /// The record that ends a file that is complete.
  [[nodiscard]] v1::JournalRecord end_record() const;
  [[nodiscard]] Result<protocols::Incident> incident(std::chrono::nanoseconds last) const;

  const JournalOptions options_;
  // Those that decide the run have their room for themselves: no flood of what only tells of it,
  // the wires and the cell's events, loses one.
  RecordQueue decisions_, tellings_;
  std::atomic<bool> wants_checkpoint_{false};
  std::uint64_t sequence_ = 0;  ///< thread: sim

  // The writer's.
  RecordQueue::Taken taken_decisions_, taken_tellings_;
  aprsim::journal::FrameEncoder encoder_;
  Frame next_;  ///< what the encoder gathers
  SceneWriter scenes_;
  FrameRing ring_;
  std::optional<JournalDisk> disk_;
  world::RunTime latest_;
  std::uint64_t clock_ = 0;               ///< steps of all epochs
  std::uint64_t gaps_ = 0, lacking_ = 0;  ///< of the queues

  mutable std::mutex mutex_;  ///< of all below; never held while something is written
  std::condition_variable_any wake_;
  bool hurried_ = false, closed_ = false;
  std::vector<Wanted> wanted_;
  JournalStats stats_;
  std::jthread thread_;  // ends first
};

}  // namespace aprsim::server::journal
