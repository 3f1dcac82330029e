#pragma once

#include <fstream>
#include <span>
#include <string>

#include "world/base/result.hpp"

namespace aprsim::files {

/// A file that is written under another name beside its place and renamed when it is complete: a
/// program that fails or ends before leaves what was there. A device or a pipe is written directly,
/// a symbolic link keeps its target's place. Thread: one.
class DraftFile {
 public:
  explicit DraftFile(const std::string& place);
  /// Removes a draft that was not committed.
  ~DraftFile();
  DraftFile(const DraftFile&) = delete;
  DraftFile& operator=(const DraftFile&) = delete;

  /// In a failed state when the draft cannot be opened or written; commit() reports the cause.
  [[nodiscard]] std::ostream& out() { return out_; }
  /// Writes what is buffered and puts the file in its place. Errors: kUnavailable, field "file",
  /// with the place and the cause.
  [[nodiscard]] Result<void> commit();
  /// The cause of a failure so far as an errno; 0 = none.
  [[nodiscard]] int error() const { return error_; }

 private:
  void open();

  std::string place_;           ///< as it was named
  std::string target_, draft_;  ///< without symbolic links; no draft = written directly
  std::ofstream out_;
  int error_ = 0;
};

/// Checks that no output is the file of an input or of another output, by whichever name, so that
/// nothing is overwritten that is still to be read. Errors: kInvalidArgument, field "output".
[[nodiscard]] Result<void> check_outputs(std::span<const std::string> inputs,
                                         std::span<const std::string> outputs);

}  // namespace aprsim::files
