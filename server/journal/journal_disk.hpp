#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>

#include "aprsim/v1/journal.pb.h"
#include "server/journal/frame.hpp"
#include "server/journal/journal_files.hpp"
#include "server/journal/journal_stats.hpp"

namespace aprsim::server::journal {

/// The first bytes of a journal file: magic and header. Thread: any.
[[nodiscard]] std::string header_bytes(const v1::JournalHeader& header, std::uint32_t part);

/// The files of a run. Each begins with the header and a frame with a checkpoint. Frames that
/// cannot be written, or for which a slow reader leaves no room, are dropped; a gap record before
/// the next frame and a log line report it. A file that had to be given up ends with that gap until
/// a further file exists. Thread: one at a time.
class JournalDisk {
 public:
  /// `place` and `max_file_bytes`: as for JournalFiles. `header`: of the run; it outlives the disk,
  /// which sets `part`.
  JournalDisk(std::string place, std::uint64_t max_file_bytes, const v1::JournalHeader& header,
              std::size_t max_waiting_bytes = std::size_t{16} << 20);

  /// As JournalFiles::claim().
  [[nodiscard]] Result<void> claim() { return files_.claim(); }
  void append(const Frame& frame);
  /// Writes waiting frames as far as the reader accepts them.
  void write_waiting();
  /// Writes waiting frames until the deadline and closes the file.
  void finish(std::chrono::steady_clock::time_point deadline);
  /// Whether a frame with a checkpoint is wanted: after a gap, or for a new file.
  [[nodiscard]] bool wants_beginning() const;
  [[nodiscard]] const JournalStats& stats() const { return stats_; }

 private:
  struct Waiting {
    FrameBytes bytes;
    std::uint64_t records = 0;
    Missing held;
    std::uint64_t reported = 0;  ///< missing records that this gap reports
    std::size_t done = 0;
  };
  [[nodiscard]] bool open_next();
  void wait(FrameBytes bytes, std::uint64_t records, const Missing& held,
            std::uint64_t reported = 0);
  void record_gap();
  void end_with_gap();
  /// Counts a dropped frame; `known` of its records are counted as missing already.
  void count_missing(const Missing& held, const std::string& why, std::uint64_t known = 0);
  void failed(const std::string& why);

  JournalFiles files_;
  const v1::JournalHeader& header_;
  const std::size_t max_waiting_bytes_;  ///< of frames that a slow reader has not taken
  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0;
  Missing missing_;               ///< not reported yet
  std::uint64_t ended_with_ = 0;  ///< missing records that the given-up file reports
  bool wants_beginning_ = false;
  std::chrono::steady_clock::time_point retry_at_{};
  std::string last_error_;  ///< as logged
  JournalStats stats_;
};

}  // namespace aprsim::server::journal
