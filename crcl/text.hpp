#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// The lexical forms of XML Schema's simple types, independent of any locale.
namespace aprsim::crcl {

inline constexpr std::string_view kXmlSpace = " \t\r\n";

/// Without XML white space at either end.
[[nodiscard]] std::string_view trim(std::string_view text);

/// xs:double, with INF, -INF and NaN. Empty if `text` is no such number.
[[nodiscard]] std::optional<double> parse_double(std::string_view text);
/// xs:long.
[[nodiscard]] std::optional<std::int64_t> parse_long(std::string_view text);
/// xs:int.
[[nodiscard]] std::optional<int> parse_int(std::string_view text);
/// xs:boolean: true, false, 1, 0.
[[nodiscard]] std::optional<bool> parse_bool(std::string_view text);

/// Shortest text that parses back to the same double; INF, -INF, NaN as XML Schema spells them.
void append_double(std::string& out, double value);
void append_long(std::string& out, std::int64_t value);

/// Character data: markup escaped, bytes that XML or UTF-8 do not allow replaced by U+FFFD.
void append_escaped(std::string& out, std::string_view text);

/// At most `limit` bytes of `text`, for error messages; ends at a character boundary.
[[nodiscard]] std::string shorten(std::string_view text, std::size_t limit = 80);

}  // namespace aprsim::crcl
