#include "clients/aprsim/text/event_text.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>

#include <fmt/format.h>

namespace aprsim::client {
namespace {

constexpr std::string_view kPrefix = "CELL_EVENT_KIND_";

}  // namespace

std::string event_kind_word(v1::CellEventKind kind) {
  std::string word = v1::CellEventKind_Name(kind);
  if (!word.starts_with(kPrefix)) return std::to_string(static_cast<int>(kind));
  word.erase(0, kPrefix.size());
  std::ranges::transform(word, word.begin(), [](unsigned char c) {
    return c == '_' ? '-' : static_cast<char>(std::tolower(c));
  });
  return word;
}

std::vector<std::string> event_kind_words() {
  std::vector<std::string> words;
  for (int kind = 1; kind <= v1::CellEventKind_MAX; ++kind) {
    words.push_back(event_kind_word(static_cast<v1::CellEventKind>(kind)));
  }
  return words;
}

std::optional<v1::CellEventKind> event_kind(const std::string& word) {
  for (int kind = 1; kind <= v1::CellEventKind_MAX; ++kind) {
    if (event_kind_word(static_cast<v1::CellEventKind>(kind)) == word) {
      return static_cast<v1::CellEventKind>(kind);
    }
  }
  return std::nullopt;
}

std::string event_line(const v1::CellEvent& event) {
  const double time_s =
      static_cast<double>(event.sim_time().seconds()) + 1e-9 * event.sim_time().nanos();
  std::string line = fmt::format("{:>6} {:>10.3f} s  {:<16}", event.sequence(), time_s,
                                 event_kind_word(event.kind()));
  for (const auto& name : event.names()) line += " " + name;
  if (event.number() != 0) line += fmt::format(" #{}", event.number());
  if (!event.text().empty()) line += "  " + event.text();
  return line.substr(0, line.find_last_not_of(' ') + 1);
}

}  // namespace aprsim::client
