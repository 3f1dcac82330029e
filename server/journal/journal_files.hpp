#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "world/base/result.hpp"

namespace aprsim::server::journal {

/// The files of a run, one after the other: each is closed when it is large enough. A failed write
/// leaves whole frames only in a regular file, which can then end with a frame that reports the
/// gap. A pipe or FIFO is one endless file and accepts what its reader leaves room for; writes
/// never block. Thread: one at a time.
class JournalFiles {
 public:
  /// `place`: a file, whose successors get ".2", ".3", ... behind their name; or a directory, for
  /// files named by `stamp`, which no other run has.
  JournalFiles(std::string place, std::string stamp, std::uint64_t max_bytes);
  ~JournalFiles();
  JournalFiles(const JournalFiles&) = delete;
  JournalFiles& operator=(const JournalFiles&) = delete;

  /// Reserves the place for this run, unless that is done: what an earlier run recorded in the file
  /// is renamed to ".old-1", ".old-2", ..., with its successors, and the new file is locked against
  /// other processes. Errors: kUnavailable with file and cause; another process records there.
  [[nodiscard]] Result<void> claim();
  /// Opens the next file, empty, readable by its owner alone. A symbolic link is followed to a pipe
  /// or device only. Errors: as claim().
  [[nodiscard]] Result<void> open_next();
  /// Whether the next frame needs a new file.
  [[nodiscard]] bool full() const { return descriptor_ < 0 || (regular_ && size_ >= max_bytes_); }
  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
  /// Writes the rest of a frame; returns how many bytes were accepted, fewer where a reader does
  /// not keep up. Errors: kUnavailable with file and cause; a regular file then holds nothing of
  /// the frame.
  [[nodiscard]] Result<std::size_t> append(std::string_view rest);
  /// Waits until more is accepted. False: not within this time.
  [[nodiscard]] bool wait_writable(std::chrono::milliseconds time) const;
  /// After a failed write: ends the present file, and removes it where it is empty.
  void give_up();
  /// Whether a file was given up, and no further one has begun.
  [[nodiscard]] bool gave_up() const { return given_up_.descriptor >= 0; }
  /// Ends the given-up file with this frame, which replaces an earlier one; false: there is no
  /// room. A further file removes it.
  bool end_with(std::string_view frame);
  void close();

  [[nodiscard]] const std::string& file() const { return file_; }
  /// Number of the present file, or of the latest that has begun, from 1; 0 = none has.
  [[nodiscard]] std::uint32_t part() const { return part_; }
  /// Marks the present file as begun: it holds something now.
  void begun();

 private:
  struct GivenUp {
    int descriptor = -1;
    std::uint64_t size = 0;  ///< of whole frames
  };
  void forget_given_up();
  /// A descriptor of a new file, or of the pipe or device that is there.
  [[nodiscard]] Result<int> open_file() const;
  /// Renames the file of an earlier run, and those that follow it.
  [[nodiscard]] Result<void> keep_earlier_run() const;
  [[nodiscard]] std::string name_of(std::uint32_t part) const;
  [[nodiscard]] tl::unexpected<Error> failed(const char* what, int error) const;

  const std::string place_, stamp_;
  const std::uint64_t max_bytes_;
  std::string file_;
  std::uint32_t part_ = 0;
  bool claimed_ = false;
  int first_ = -1;  ///< the first file, claimed and not yet used
  int lock_ = -1;   ///< the first file again: holds its lock while the run is recorded
  int descriptor_ = -1;
  bool regular_ = true;
  std::uint64_t size_ = 0;  ///< of whole frames
  GivenUp given_up_;
};

}  // namespace aprsim::server::journal
