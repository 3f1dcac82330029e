#include "server/yaml_text.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace aprsim::server {

std::string scalar(const std::string& text) {
  const auto ordinary = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '.' || c == '/';
  };
  const bool is_null = text == "null" || text == "Null" || text == "NULL";
  if (!text.empty() && !is_null && std::all_of(text.begin(), text.end(), ordinary)) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (byte < 0x20 || byte == 0x7F) {
      quoted += fmt::format("\\x{:02x}", byte);
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string ports_text(const std::map<std::string, std::uint16_t>& ports) {
  if (ports.empty()) return "    {}\n";
  std::string text;
  for (const auto& [robot, port] : ports) text += fmt::format("    {}: {}\n", scalar(robot), port);
  return text;
}

}  // namespace aprsim::server
