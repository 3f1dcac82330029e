#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "crcl/error.hpp"

namespace aprsim::crcl {

inline constexpr std::size_t kMaxCommandBytes = 65'536;
inline constexpr std::size_t kMaxStatusBytes = 1'048'576;
inline constexpr std::size_t kMaxProgramBytes = 16'777'216;

/// Cuts a stream of bytes into XML documents: a document ends with its root's end tag. NUL bytes
/// and white space between documents are dropped. Works on bytes, so a character may be split over
/// reads. Tags inside a comment or a CDATA section are text. The encoding must extend ASCII;
/// UTF-16 and UTF-32 are refused.
class Framer {
 public:
  /// One kind of document in the stream.
  struct Root {
    std::string name;
    std::size_t max_bytes;
  };

  /// A document ends with the end tag of the root that it began with; with that of the first root
  /// if none has begun.
  explicit Framer(std::vector<Root> roots);

  /// For a server: commands, and programs unless their limit is 0.
  static Framer for_commands(std::size_t max_bytes = kMaxCommandBytes,
                             std::size_t max_program_bytes = 0);
  /// For a client.
  static Framer for_statuses(std::size_t max_bytes = kMaxStatusBytes);

  void append(std::string_view bytes);

  /// The next complete document; empty while it is incomplete. kTooLarge once the present document
  /// exceeds the limit, kMalformed if it begins as UTF-16 or UTF-32 does. The stream cannot be read
  /// further after an error.
  [[nodiscard]] Result<std::optional<std::string>> next();

  /// Index of the root of the document that next() has returned last.
  [[nodiscard]] std::size_t last_root() const { return last_; }

  /// Bytes that next() has not returned yet.
  [[nodiscard]] std::size_t buffered() const { return buffer_.size() - start_; }

 private:
  struct Kind {
    std::string start_tag, end_tag;  // without the '>'
    std::size_t max_bytes;
  };

  void skip_separators();
  [[nodiscard]] bool wide_encoding() const;
  void find_root();
  [[nodiscard]] std::size_t find_end();  // one past '>', or npos
  template <typename IsTag>
  [[nodiscard]] std::size_t find_tag(const IsTag& is_tag);  // at scanned_, or npos
  void discard_consumed();

  std::vector<Kind> kinds_;
  std::size_t longest_ = 0;  // of the tags
  std::size_t widest_ = 0;   // of the limits
  std::string buffer_;
  std::size_t start_ = 0;            // of the present document
  std::optional<std::size_t> root_;  // index of its kind, once its start tag has come
  std::size_t last_ = 0;
  std::size_t scanned_ = 0;         // no relevant tag begins before this
  std::string_view section_end_{};  // end of the comment or CDATA section at scanned_
  std::size_t blank_until_ = 0;     // an end tag without '>' is followed by blanks up to here
};

}  // namespace aprsim::crcl
