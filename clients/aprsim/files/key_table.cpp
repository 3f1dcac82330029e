#include "clients/aprsim/files/key_table.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <sstream>
#include <string_view>
#include <vector>

#include "clients/aprsim/files/key_tables.hpp"

namespace aprsim::client {
namespace {

using Table = std::map<std::string, std::string>;

/// With * for a name that the file chooses.
std::string pattern_of(const std::string& key) {
  std::istringstream parts(key);
  std::string out;
  for (std::string part; std::getline(parts, part, '.');) {
    const bool is_name = std::ranges::all_of(part, [](unsigned char c) { return std::isupper(c); });
    out += (out.empty() ? "" : ".") + (is_name ? std::string("*") : part);
  }
  return out;
}

Table read_table(std::string_view text) {
  constexpr std::string_view kBar = " | ";
  Table table;
  std::istringstream lines{std::string(text)};
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.starts_with('#')) continue;
    std::vector<std::string> cells;
    std::size_t begin = 0;
    for (std::size_t end; (end = line.find(kBar, begin)) != std::string::npos;) {
      cells.push_back(line.substr(begin, end - begin));
      begin = end + kBar.size();
    }
    cells.push_back(line.substr(begin));
    if (cells.size() == 4) table[pattern_of(cells[0])] = cells[3] + ": " + cells[1];
  }
  return table;
}

/// Keys that several kinds of things have; their tables begin with these words.
std::string shared_part(const std::string& pattern) {
  for (const std::string_view common : {"pieces[]", "gripper."}) {
    const std::size_t at = pattern.rfind(common);
    if (at != std::string::npos && at > 0) return pattern.substr(at);
  }
  return "";
}

std::string pose_meaning(const std::string& pattern) {
  if (pattern.ends_with("xyz_m")) return "Position: [x, y, z]";
  if (pattern.ends_with("rpy_deg")) {
    return "Turns about the fixed axes x, y, z: [roll, pitch, yaw]";
  }
  return "";
}

}  // namespace

std::string meaning_of(FileKind kind, const std::string& pattern) {
  static const Table scene = read_table(scene_key_table());
  static const Table scenario = read_table(scenario_key_table());
  const Table& table = kind == FileKind::kScenario ? scenario : scene;
  for (const std::string& key : {pattern, shared_part(pattern)}) {
    if (const auto found = table.find(key); found != table.end()) return found->second;
  }
  if (pattern.ends_with("[]") || pattern.ends_with('*')) return "";
  if (const std::string pose = pose_meaning(pattern); !pose.empty()) return pose;
  // As that of the map around it.
  const std::size_t dot = pattern.rfind('.');
  if (dot == std::string::npos) return "";
  std::string around = pattern.substr(0, dot);
  while (around.ends_with("[]") || around.ends_with(".*")) around.resize(around.size() - 2);
  return meaning_of(kind, around);
}

}  // namespace aprsim::client
