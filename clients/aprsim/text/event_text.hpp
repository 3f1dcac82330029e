#pragma once

#include <optional>
#include <string>
#include <vector>

#include "aprsim/v1/events.pb.h"

namespace aprsim::client {

/// The kinds of events as words: "grasped", "contact-begun", ...
[[nodiscard]] std::vector<std::string> event_kind_words();
[[nodiscard]] std::string event_kind_word(v1::CellEventKind kind);
/// The kind of a word; absent for an unknown word.
[[nodiscard]] std::optional<v1::CellEventKind> event_kind(const std::string& word);

/// One line, without its end.
[[nodiscard]] std::string event_line(const v1::CellEvent& event);

}  // namespace aprsim::client
