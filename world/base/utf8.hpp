#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

/// Texts from outside, which may be no UTF-8 and may control a terminal.
namespace aprsim::utf8 {

/// Length of the well-formed character at the start of a text that is not empty (RFC 3629); 0 =
/// there is none.
[[nodiscard]] inline std::size_t length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  if (byte(0) < 0x80) return 1;
  const std::size_t size = byte(0) >= 0xF0 ? 4 : byte(0) >= 0xE0 ? 3 : 2;
  if (byte(0) < 0xC2 || byte(0) > 0xF4 || text.size() < size) return 0;
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
  }
  // Overlong forms, surrogates, and numbers beyond U+10FFFF.
  const bool invalid = (byte(0) == 0xE0 && byte(1) < 0xA0) || (byte(0) == 0xED && byte(1) > 0x9F) ||
                       (byte(0) == 0xF0 && byte(1) < 0x90) || (byte(0) == 0xF4 && byte(1) > 0x8F);
  return invalid ? 0 : size;
}

/// Whether a character controls a terminal or the direction of the text: C0, DEL, C1, and the
/// embeddings, overrides and isolates of the bidirectional algorithm.
[[nodiscard]] inline bool is_control(std::string_view character) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(character[i]); };
  if (character.size() == 1) return byte(0) < 0x20 || byte(0) == 0x7F;
  if (character.size() == 2) return byte(0) == 0xC2 && byte(1) < 0xA0;
  if (character.size() != 3 || byte(0) != 0xE2) return false;
  return (byte(1) == 0x80 && byte(2) >= 0xA8 && byte(2) <= 0xAE) ||
         (byte(1) == 0x81 && byte(2) >= 0xA6 && byte(2) <= 0xA9);
}

[[nodiscard]] inline bool is_valid(std::string_view text) {
  while (!text.empty()) {
    const std::size_t size = length(text);
    if (size == 0) return false;
    text.remove_prefix(size);
  }
  return true;
}

/// Appends each byte as "\xNN".
inline void append_escaped(std::string& out, std::string_view bytes) {
  static constexpr char kDigits[] = "0123456789abcdef";
  for (const char c : bytes) {
    const auto byte = static_cast<std::uint8_t>(c);
    out += {'\\', 'x', kDigits[byte >> 4U], kDigits[byte & 0xFU]};
  }
}

/// The text in valid UTF-8: bytes that are none become "\xNN".
[[nodiscard]] inline std::string valid(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t size = length(text);
    if (size == 0) {
      append_escaped(out, text.substr(0, 1));
    } else {
      out += text.substr(0, size);
    }
    text.remove_prefix(std::max<std::size_t>(size, 1));
  }
  return out;
}

/// The text as a terminal may show it: control characters, except those in `kept`, and bytes that
/// are no UTF-8 become "\xNN".
[[nodiscard]] inline std::string printable(std::string_view text, std::string_view kept = "") {
  std::string out;
  while (!text.empty()) {
    const std::size_t size = std::max<std::size_t>(length(text), 1);
    const std::string_view character = text.substr(0, size);
    const bool keeps = size == 1 && kept.find(character) != std::string_view::npos;
    if (!keeps && (length(text) == 0 || is_control(character))) {
      append_escaped(out, character);
    } else {
      out += character;
    }
    text.remove_prefix(size);
  }
  return out;
}

/// At most `limit` bytes of a text in UTF-8, cut between two characters.
[[nodiscard]] inline std::string_view cut(std::string_view text, std::size_t limit) {
  if (text.size() <= limit) return text;
  while (limit > 0 && (static_cast<std::uint8_t>(text[limit]) & 0xC0U) == 0x80U) --limit;
  return text.substr(0, limit);
}

}  // namespace aprsim::utf8
