#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "world/base/result.hpp"

namespace aprsim::server::journal {

/// Where frames go: one file after the other, each closed by then when it is large enough. A write
/// that fails leaves a regular file with whole frames only, and room for one frame that says what
/// is missing behind them; a pipe or FIFO is one endless file, and takes what its reader lets it,
/// without a wait. Thread: one at a time.
class JournalFiles {
 public:
  /// `place`: a file, whose successors get ".2", ".3", ... behind their name; or a directory, for
  /// files named by `stamp`.
  JournalFiles(std::string place, std::string stamp, std::uint64_t max_bytes);
  ~JournalFiles();
  JournalFiles(const JournalFiles&) = delete;
  JournalFiles& operator=(const JournalFiles&) = delete;

  /// Opens the next file, empty. Errors: kUnavailable with file and cause.
  [[nodiscard]] Result<void> open_next();
  /// Whether the present file, if there is one, is as large as a file may become.
  [[nodiscard]] bool full() const { return descriptor_ < 0 || (regular_ && size_ >= max_bytes_); }
  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
  /// Writes the rest of a frame; how much of it was taken, which is all of it but where a reader
  /// does not keep up. Errors: kUnavailable with file and cause; nothing of the frame is in a
  /// regular file then.
  [[nodiscard]] Result<std::size_t> append(std::string_view rest);
  /// Waits until more may be taken. False: not within this time.
  [[nodiscard]] bool wait_writable(std::chrono::milliseconds time) const;
  /// After a write that failed: the present file takes no more frames. One that holds nothing is
  /// removed.
  void give_up();
  /// Whether a file was given up, and no further one has begun.
  [[nodiscard]] bool gave_up() const { return given_up_.descriptor >= 0; }
  /// Ends the file that was given up with this frame, in place of one that it ended with before;
  /// false: there is no room for it. Once a further file has begun it is gone from there.
  bool end_with(std::string_view frame);
  void close();

  [[nodiscard]] const std::string& file() const { return file_; }
  /// Number of the present file, or of the latest that has begun, from 1; 0 = none has.
  [[nodiscard]] std::uint32_t part() const { return part_; }
  /// The present file holds something now.
  void begun();

 private:
  struct GivenUp {
    int descriptor = -1;
    std::uint64_t size = 0;  ///< of whole frames
  };
  void forget_given_up();
  [[nodiscard]] std::string name_of(std::uint32_t part) const;
  [[nodiscard]] tl::unexpected<Error> failed(const char* what, int error) const;

  const std::string place_, stamp_;
  const std::uint64_t max_bytes_;
  std::string file_;
  std::uint32_t part_ = 0;
  int descriptor_ = -1;
  bool regular_ = true;
  std::uint64_t size_ = 0;  ///< of whole frames
  GivenUp given_up_;
};

}  // namespace aprsim::server::journal
