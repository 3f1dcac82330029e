#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "crcl/error.hpp"

namespace aprsim::crcl {

inline constexpr std::size_t kMaxCommandBytes = 65'536;
inline constexpr std::size_t kMaxStatusBytes = 1'048'576;

/// Cuts a stream of bytes into XML documents: a document ends with its root's end tag. NUL bytes
/// and white space between documents are dropped. Works on bytes, so a character may be split over
/// reads. An end tag inside a comment ends the document too, as in the reference servers.
class Framer {
 public:
  /// Documents that end with </root>, at most `max_bytes` each.
  Framer(std::string_view root, std::size_t max_bytes);

  /// What a server receives.
  static Framer for_commands(std::size_t max_bytes = kMaxCommandBytes);
  /// What a client receives.
  static Framer for_statuses(std::size_t max_bytes = kMaxStatusBytes);

  void append(std::string_view bytes);

  /// The next complete document, or nothing yet. kTooLarge once the present document exceeds the
  /// limit; the stream cannot be read any further then.
  [[nodiscard]] Result<std::optional<std::string>> next();

  /// Bytes held that belong to no complete document that next() has returned.
  [[nodiscard]] std::size_t buffered() const { return buffer_.size() - start_; }

 private:
  void skip_separators();
  [[nodiscard]] std::size_t find_end();  // one past '>', or npos
  void discard_consumed();

  std::string end_tag_;  // without the '>'
  std::size_t max_bytes_;
  std::string buffer_;
  std::size_t start_ = 0;    // of the present document
  std::size_t scanned_ = 0;  // no end tag begins before this
};

}  // namespace aprsim::crcl
