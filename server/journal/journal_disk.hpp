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

/// What a journal file begins with: its magic and the header. Thread: any.
[[nodiscard]] std::string header_bytes(const v1::JournalHeader& header, std::uint32_t part);

/// The files of a run: each begins with the header and then a frame that begins. Frames that cannot
/// be written, or for which a slow reader leaves no room, are missing; the next one that is written
/// stands behind a gap that says so, and the log says it too. A file that could not be gone on with
/// ends with that gap as long as there is no further one. Thread: one at a time.
class JournalDisk {
 public:
  /// `place` and `max_file_bytes`: as of JournalFiles. `header` of the run, which outlives the
  /// disk; `part` is the disk's.
  JournalDisk(std::string place, std::uint64_t max_file_bytes, const v1::JournalHeader& header);

  void put(const Frame& frame);
  /// What waits, as far as the reader takes it.
  void write_waiting();
  /// The same, until the deadline; then it closes the file.
  void finish(std::chrono::steady_clock::time_point deadline);
  /// Whether a frame that begins is wanted: something is missing, or a file.
  [[nodiscard]] bool wants_beginning() const;
  [[nodiscard]] const JournalStats& stats() const { return stats_; }

 private:
  struct Waiting {
    FrameBytes bytes;
    std::uint64_t records = 0;
    Missing held;
    std::uint64_t told = 0;  ///< records whose loss this is to tell of
    std::size_t done = 0;
  };
  [[nodiscard]] bool open_next();
  void wait(FrameBytes bytes, std::uint64_t records, const Missing& held, std::uint64_t told = 0);
  void tell_gap();
  void end_with_gap();
  /// `known`: how many of the records are counted as missing already.
  void lose(const Missing& held, const std::string& why, std::uint64_t known = 0);
  void failed(const std::string& why);

  JournalFiles files_;
  const v1::JournalHeader& header_;
  std::deque<Waiting> waiting_;
  std::size_t waiting_bytes_ = 0;
  Missing missing_;               ///< still to be told
  std::uint64_t ended_with_ = 0;  ///< records missing, as the file that was given up tells it
  bool wants_beginning_ = false;
  std::chrono::steady_clock::time_point retry_at_{};
  std::string trouble_;  ///< that the log has told of
  JournalStats stats_;
};

}  // namespace aprsim::server::journal
