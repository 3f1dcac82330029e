#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace aprsim::client {

/// A line of YAML, split at its comment.
struct SourceLine {
  std::string content;  ///< without trailing spaces; empty = none
  std::string comment;  ///< with its #; empty = none
};

/// The lines of a text. A # within quotes or within a word begins no comment.
[[nodiscard]] std::vector<SourceLine> split_comments(std::string_view text);

}  // namespace aprsim::client
