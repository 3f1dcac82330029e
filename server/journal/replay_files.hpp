#pragma once

#include <string>
#include <vector>

#include "server/journal/replay.hpp"

namespace aprsim::server::journal {

/// A run again, from its files.
struct FilesReplayed {
  v1::JournalHeader header;
  std::vector<std::string> cautions;  ///< why bits may differ
  ReplayResult result;
};

/// Runs what the files of one run have recorded, in their order, and compares; `version`: of this
/// program. Errors: kInvalidArgument with the file (no journal, of another run than the first), and
/// of a record that cannot be; kNotFound, kUnavailable. Thread: any.
[[nodiscard]] Result<FilesReplayed> replay_files(const std::vector<std::string>& files,
                                                 const std::string& version);

/// In words: what was run, and where it first differs.
[[nodiscard]] std::string text_of(const FilesReplayed& replayed);

}  // namespace aprsim::server::journal
