#pragma once

#include <cstdint>
#include <string>

#include "world/api/error.hpp"

namespace aprsim::server::journal {

/// Where frames go: one file after the other, each closed by then when it is large enough. A write
/// that fails leaves the file with whole frames only. Thread: one at a time.
class JournalFiles {
 public:
  /// `place`: a file, whose successors get ".2", ".3", ... behind their name; or a directory, for
  /// files named by `stamp`.
  JournalFiles(std::string place, std::string stamp, std::uint64_t max_bytes);
  ~JournalFiles();
  JournalFiles(const JournalFiles&) = delete;
  JournalFiles& operator=(const JournalFiles&) = delete;

  /// Begins the next file: its magic, and then `frame`. Errors: kUnavailable with file and cause.
  [[nodiscard]] Result<void> open_next(const std::string& frame);
  /// Whether the present file, if there is one, is as large as a file may become.
  [[nodiscard]] bool full() const { return descriptor_ < 0 || size_ >= max_bytes_; }
  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
  /// Errors: kUnavailable with file and cause; nothing of the frame is in the file then.
  [[nodiscard]] Result<void> append(const std::string& frame);
  void close();

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] std::uint32_t part() const { return part_; }  ///< from 1

 private:
  [[nodiscard]] std::string name_of(std::uint32_t part) const;
  [[nodiscard]] tl::unexpected<Error> failed(const char* what, int error) const;

  const std::string place_, stamp_;
  const std::uint64_t max_bytes_;
  std::string file_;
  std::uint32_t part_ = 0;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace aprsim::server::journal
