#include "clients/aprsim/cli/console.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "world/base/utf8.hpp"

namespace aprsim::client {
namespace {

constexpr std::string_view kKept = "\n\t";

/// Length of the colour sequence (ECMA-48, SGR) at the start of a text; 0 = none.
std::size_t colour_length(std::string_view text) {
  if (!text.starts_with("\x1b[")) return 0;
  const std::size_t end = text.find_first_not_of("0123456789;", 2);
  return end == std::string_view::npos || text[end] != 'm' ? 0 : end + 1;
}

/// The code point of a character in UTF-8 of at most three bytes.
std::uint32_t code_point(std::string_view character) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(character[i]); };
  if (character.size() == 1) return byte(0);
  if (character.size() == 2) return (byte(0) & 0x1FU) << 6U | (byte(1) & 0x3FU);
  return (byte(0) & 0x0FU) << 12U | (byte(1) & 0x3FU) << 6U | (byte(2) & 0x3FU);
}

/// JSON on one line. The library escapes control characters of ASCII only.
std::string json_line(const nlohmann::ordered_json& object) {
  const std::string text =
      object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string out;
  for (std::string_view left = text; !left.empty();) {
    const std::string_view character = left.substr(0, std::max<std::size_t>(utf8::length(left), 1));
    out += utf8::is_control(character) ? fmt::format("\\u{:04x}", code_point(character))
                                       : std::string(character);
    left.remove_prefix(character.size());
  }
  return out + '\n';
}

}  // namespace

void Console::show(const std::string& text, const nlohmann::ordered_json& object) {
  if (json) {
    print_json(object);
  } else {
    print(text);
  }
}

void Console::print(std::string_view text) { write(escaped(text)); }

void Console::print_json(const nlohmann::ordered_json& object) { write(json_line(object)); }

std::string Console::escaped(std::string_view text) const {
  if (!screen.out.on()) return utf8::printable(text, kKept);
  std::string printable;
  while (!text.empty()) {
    const std::size_t colour = colour_length(text);
    printable += text.substr(0, colour);
    text.remove_prefix(colour);
    if (text.empty()) break;
    const std::size_t next = std::min(text.find('\x1b', colour > 0 ? 0 : 1), text.size());
    printable += utf8::printable(text.substr(0, next), kKept);
    text.remove_prefix(next);
  }
  return printable;
}

void Console::write(std::string_view bytes) {
  errno = 0;
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.flush();
  if (!out && output_error == 0) output_error = errno != 0 ? errno : EIO;
}

}  // namespace aprsim::client
