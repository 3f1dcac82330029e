#include "world/base/yaml/yaml_reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <system_error>

#include "world/base/yaml/key_recorder.hpp"
#include "world/base/yaml/yaml_tree.hpp"

namespace aprsim::yaml {

using detail::Value;

namespace {

std::string shown(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

/// A default, which may come from a conversion of units.
std::string rounded(double value) {
  char buffer[32];
  const auto end =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, 12).ptr;
  return {buffer, end};
}

/// Parses the whole of `text`, which may have a leading plus.
template <typename T>
std::optional<T> parse_number(std::string_view text) {
  if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-')) return std::nullopt;
  }
  T value{};
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<double> finite_number(const Value& value) {
  if (value.kind != Value::Kind::kScalar || value.quoted) return std::nullopt;
  const auto number = parse_number<double>(value.scalar);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

std::string count_text(std::size_t min, std::size_t max) {
  return min == max ? std::to_string(min) : std::to_string(min) + " to " + std::to_string(max);
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& known) {
  const std::string near = nearest_word(word, known);
  return near.empty() ? "" : " (did you mean " + near + "?)";
}

/// A whole number of YAML's core schema, decimal or hexadecimal (0x8000).
std::optional<std::int64_t> whole_number(std::string_view text) {
  constexpr std::string_view kHexadecimal = "0x";
  if (!text.starts_with(kHexadecimal)) return parse_number<std::int64_t>(text);
  text.remove_prefix(kHexadecimal.size());
  std::uint32_t number = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number, 16);
  const bool whole = problem == std::errc() && end == text.data() + text.size();
  return whole ? std::optional<std::int64_t>(number) : std::nullopt;
}

}  // namespace

bool Range::holds(double value) const {
  return (open_min ? value > min : value >= min) && (open_max ? value < max : value <= max);
}

std::string Range::text() const {
  const bool low = std::isfinite(min), high = std::isfinite(max);
  if (low && high) {
    return std::string(" in ") + (open_min ? "(" : "[") + shown(min) + ", " + shown(max) +
           (open_max ? ")" : "]");
  }
  if (low) return (open_min ? " > " : " >= ") + shown(min);
  if (high) return (open_max ? " < " : " <= ") + shown(max);
  return "";
}

std::string Node::where() const { return place_->mark.text(); }

bool Node::is_list() const {
  if (context_->recorder) return value_ && context_->recorder->form(key_) == 1;
  return value_ && value_->kind == Value::Kind::kList;
}

bool Node::is_map() const {
  if (context_->recorder) return value_ && context_->recorder->form(key_) == 2;
  return value_ && value_->kind == Value::Kind::kMap;
}

std::string Node::found() const {
  if (!value_ || value_->kind == Value::Kind::kNull) return "nothing";
  if (value_->kind == Value::Kind::kList) return "a list";
  if (value_->kind == Value::Kind::kMap) return "a map";
  std::string text = value_->scalar.substr(0, 60);
  if (text.size() < value_->scalar.size()) text += "...";
  return finite_number(*value_) ? text : '"' + text + '"';
}

void Node::error(const std::string& found, const std::string& expected, ErrorCode code) const {
  if (context_->recorder) {
    if (!value_) context_->recorder->demand(key_);
    return;
  }
  if (context_->error && !context_->collects) return;
  context_->add(Error{code, key_,
                      where() + ": " + (key_.empty() ? "" : key_ + ": ") + "found " + found +
                          ", expected " + expected});
}

void Node::note_words(std::span<const std::string> words) const {
  if (context_->recorder) context_->recorder->note_words(key_, words);
}

void Node::note_names(std::span<const std::string> names) const {
  if (context_->recorder) context_->recorder->note_names(key_, names);
}

void Node::unexpected(const std::string& expected, ErrorCode code) const {
  error(found(), expected, code);
}

double Node::number(const Range& range) const {
  if (context_->recorder) {
    if (!value_) context_->recorder->demand(key_);
    return context_->recorder->number(key_, range);
  }
  const auto number = value_ ? finite_number(*value_) : std::nullopt;
  if (number && range.holds(*number)) return *number;
  unexpected("a number" + range.text());
  return 0;
}

double Node::number_or(double fallback, const Range& range) const {
  if (context_->recorder) {
    context_->recorder->fallback(key_, rounded(fallback));
    const double value = context_->recorder->number(key_, range);
    return value_ ? value : fallback;
  }
  return value_ ? number(range) : fallback;
}

std::int64_t Node::integer(std::int64_t min, std::int64_t max) const {
  if (context_->recorder) {
    if (!value_) context_->recorder->demand(key_);
    return context_->recorder->integer(key_, min, max);
  }
  if (value_ && value_->kind == Value::Kind::kScalar && !value_->quoted) {
    const auto number = whole_number(value_->scalar);
    if (number && *number >= min && *number <= max) return *number;
  }
  const bool bounded = max != std::numeric_limits<std::int64_t>::max();
  unexpected("a whole number " +
             (bounded ? "in [" + std::to_string(min) + ", " + std::to_string(max) + "]"
                      : ">= " + std::to_string(min)));
  return min;
}

std::int64_t Node::integer_or(std::int64_t fallback, std::int64_t min, std::int64_t max) const {
  if (context_->recorder) {
    context_->recorder->fallback(key_, std::to_string(fallback));
    const std::int64_t value = context_->recorder->integer(key_, min, max);
    return value_ ? value : fallback;
  }
  return value_ ? integer(min, max) : fallback;
}

bool Node::boolean() const {
  if (context_->recorder) {
    if (!value_) context_->recorder->demand(key_);
    return context_->recorder->boolean(key_);
  }
  if (value_ && value_->kind == Value::Kind::kScalar && !value_->quoted) {
    if (value_->scalar == "true") return true;
    if (value_->scalar == "false") return false;
  }
  unexpected("true or false");
  return false;
}

bool Node::boolean_or(bool fallback) const {
  if (context_->recorder) {
    context_->recorder->fallback(key_, fallback ? "true" : "false");
    const bool value = context_->recorder->boolean(key_);
    return value_ ? value : fallback;
  }
  return value_ ? boolean() : fallback;
}

std::string Node::text() const {
  if (context_->recorder) {
    if (!value_) context_->recorder->demand(key_);
    return context_->recorder->text(key_);
  }
  if (value_ && value_->kind == Value::Kind::kScalar && !value_->scalar.empty()) {
    return value_->scalar;
  }
  unexpected("text");
  return "";
}

std::string Node::text_or(const std::string& fallback) const {
  if (context_->recorder) {
    context_->recorder->fallback(key_, fallback);
    const std::string value = context_->recorder->text(key_);
    return value_ ? value : fallback;
  }
  return value_ ? text() : fallback;
}

std::size_t Node::word(std::span<const std::string_view> words) const {
  if (context_->recorder) {
    if (!value_) context_->recorder->demand(key_);
    return context_->recorder->word(key_, words);
  }
  const std::vector<std::string> known(words.begin(), words.end());
  if (value_ && value_->kind == Value::Kind::kScalar) {
    const auto it = std::find(known.begin(), known.end(), value_->scalar);
    if (it != known.end()) return static_cast<std::size_t>(it - known.begin());
    unexpected("one of " + joined(known) + suggestion(value_->scalar, known));
  } else {
    unexpected("one of " + joined(known));
  }
  return 0;
}

std::size_t Node::word_or(std::size_t fallback,
                          std::initializer_list<std::string_view> words) const {
  if (context_->recorder) {
    const std::span all(words.begin(), words.size());
    context_->recorder->fallback(key_, std::string(all[fallback]));
    const std::size_t value = context_->recorder->word(key_, all);
    return value_ ? value : fallback;
  }
  return value_ ? word(words) : fallback;
}

std::vector<double> Node::numbers(std::size_t min_count, std::size_t max_count,
                                  const Range& range) const {
  if (context_->recorder) return recorded_numbers(min_count, max_count, range);
  std::vector<double> result;
  const std::string expected = "a list of " + count_text(min_count, max_count) + " numbers";
  if (!is_list()) {
    unexpected(expected);
  } else if (value_->items.size() < min_count || value_->items.size() > max_count) {
    error("a list of " + std::to_string(value_->items.size()), expected);
  } else {
    for (const Node& item : items()) result.push_back(item.number(range));
  }
  if (result.size() < min_count) result.resize(min_count, 0.0);
  return result;
}

std::vector<double> Node::recorded_numbers(std::size_t min_count, std::size_t max_count,
                                           const Range& range) const {
  if (!value_) context_->recorder->demand(key_);
  std::vector<double> result(context_->recorder->list(key_, min_count, max_count));
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = context_->recorder->number(key_ + "[" + std::to_string(i) + "]", range);
  }
  return result;
}

std::vector<Node> Node::items() const {
  std::vector<Node> result;
  if (context_->recorder) {
    const std::size_t count = context_->recorder->items(key_);
    for (std::size_t i = 0; value_ && i < count; ++i) {
      result.push_back(Node(context_, value_, value_, key_ + "[" + std::to_string(i) + "]"));
    }
    return result;
  }
  if (!value_) return result;
  if (!is_list()) {
    unexpected("a list");
    return result;
  }
  for (std::size_t i = 0; i < value_->items.size(); ++i) {
    const Value& item = value_->items[i];
    result.push_back(Node(context_, &item, &item, key_ + "[" + std::to_string(i) + "]"));
  }
  return result;
}

std::vector<std::pair<std::string, Node>> Node::entries() const {
  std::vector<std::pair<std::string, Node>> result;
  if (context_->recorder) {
    std::string name = context_->recorder->name(key_);
    std::string path = key_.empty() ? "*" : key_ + ".*";
    if (value_) {
      result.emplace_back(std::move(name), Node(context_, value_, value_, std::move(path)));
    }
    return result;
  }
  if (!value_) return result;
  if (!is_map()) {
    unexpected("a map");
    return result;
  }
  for (const detail::Entry& entry : value_->entries) {
    std::string path = key_.empty() ? entry.key : key_ + "." + entry.key;
    result.emplace_back(entry.key, Node(context_, &entry.value, &entry.value, std::move(path)));
  }
  return result;
}

Map Node::map(std::initializer_list<std::string_view> known) const {
  return map(std::span(known.begin(), known.size()));
}

Map Node::map(std::span<const std::string_view> known) const {
  std::vector<std::string> words(known.begin(), known.end());
  if (context_->recorder) {
    if (!value_) context_->recorder->demand(key_);
    context_->recorder->map(key_, known);
    return {*this, std::move(words)};
  }
  if (!is_map()) {
    unexpected("a map with the keys " + joined(words));
    return {Node(context_, nullptr, place_, key_), std::move(words)};
  }
  for (const detail::Entry& entry : value_->entries) {
    if (std::find(words.begin(), words.end(), entry.key) != words.end()) continue;
    const Value at{.mark = entry.mark};
    const std::string prefix = key_.empty() ? "" : key_ + ".";
    Node(context_, nullptr, &at, prefix + entry.key)
        .error("an unknown key", "one of " + joined(words) + suggestion(entry.key, words));
    if (const std::string near = nearest_word(entry.key, words); !near.empty()) {
      context_->mistyped.push_back(prefix + near);
    }
  }
  return {*this, std::move(words)};
}

Node Map::operator[](std::string_view key) const {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) {
    throw std::logic_error("key " + std::string(key) + " is not among those of " + node_.key());
  }
  std::string path = node_.key_.empty() ? std::string(key) : node_.key_ + "." + std::string(key);
  if (node_.context_->recorder) {
    // Within an absent map nothing is demanded but the map itself.
    const bool present = node_.value_ && node_.context_->recorder->is_present(path);
    return {node_.context_, present ? node_.value_ : nullptr, node_.place_, std::move(path)};
  }
  const detail::Entry* entry = node_.value_ ? node_.value_->find(key) : nullptr;
  if (!entry) return {node_.context_, nullptr, node_.place_, std::move(path)};
  return {node_.context_, &entry->value, &entry->value, std::move(path)};
}

std::string nearest_word(std::string_view word, const std::vector<std::string>& known) {
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : known) {
    std::vector<std::size_t> row(candidate.size() + 1);
    for (std::size_t j = 0; j <= candidate.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i;
      for (std::size_t j = 1; j <= candidate.size(); ++j) {
        const std::size_t replaced = diagonal + (word[i - 1] == candidate[j - 1] ? 0 : 1);
        diagonal = row[j];
        row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return best;
}

}  // namespace aprsim::yaml
