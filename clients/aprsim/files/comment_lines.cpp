#include "clients/aprsim/files/comment_lines.hpp"

namespace aprsim::client {
namespace {

std::string trimmed(std::string_view text) {
  const std::size_t end = text.find_last_not_of(" \t\r");
  return end == std::string_view::npos ? "" : std::string(text.substr(0, end + 1));
}

/// Follows quotes through the text, which may go on over lines.
class Quotes {
 public:
  /// Whether the character is outside quotes, after it was read.
  bool read(char c) {
    if (quote_ != 0) {
      if (escaped_) {
        escaped_ = false;
      } else if (quote_ == '"' && c == '\\') {
        escaped_ = true;
      } else if (c == quote_) {
        // A doubled ' closes and opens again.
        quote_ = 0;
        last_ = c;
      }
      return false;
    }
    const bool begins = std::string_view("[{,:-").find(last_) != std::string_view::npos ||
                        (c == '\'' && last_ == '\'');
    if ((c == '"' || c == '\'') && begins) {
      quote_ = c;
      return false;
    }
    if (c != ' ' && c != '\t') last_ = c;
    return true;
  }

  [[nodiscard]] bool is_open() const { return quote_ != 0; }
  void end_line() {
    if (quote_ == 0) last_ = '-';
  }

 private:
  char quote_ = 0;
  bool escaped_ = false;
  char last_ = '-';  // other than a space; '-' where a value may begin
};

}  // namespace

std::vector<SourceLine> split_comments(std::string_view text) {
  std::vector<SourceLine> lines;
  Quotes quotes;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    std::size_t comment = line.size();
    for (std::size_t i = 0; i < line.size(); ++i) {
      const bool separate = i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t';
      if (line[i] == '#' && separate && !quotes.is_open()) {
        comment = i;
        break;
      }
      quotes.read(line[i]);
    }
    quotes.end_line();
    lines.push_back({trimmed(line.substr(0, comment)), trimmed(line.substr(comment))});
  }
  return lines;
}

}  // namespace aprsim::client
