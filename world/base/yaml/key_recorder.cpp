#include "world/base/yaml/key_recorder.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace aprsim::yaml {
namespace {

constexpr std::string_view kName = "NAME";

/// Without the indices of lists.
std::string pattern_of(const std::string& key) {
  std::string out;
  bool within = false;
  for (const char c : key) {
    if (c == ']') within = false;
    if (!within) out += c;
    if (c == '[') within = true;
  }
  return out;
}

void add(std::vector<std::string>& into, std::string_view word) {
  if (std::ranges::find(into, word) == into.end()) into.emplace_back(word);
}

/// FNV-1a with a final mix, the same on every machine.
std::uint64_t hash_of(std::uint64_t seed, std::string_view a, std::string_view b) {
  std::uint64_t hash = 14695981039346656037ULL ^ (seed * 0x9e3779b97f4a7c15ULL);
  for (const std::string_view text : {a, std::string_view("|"), b}) {
    for (const char c : text) {
      hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
    }
  }
  hash ^= hash >> 31;
  hash *= 0xbf58476d1ce4e5b9ULL;
  return hash ^ (hash >> 29);
}

}  // namespace

const KeyEntry* KeySchema::find(std::string_view key) const {
  const auto it = std::ranges::find(keys, key, &KeyEntry::key);
  return it == keys.end() ? nullptr : &*it;
}

void KeyRecorder::Bound::merge(double limit, bool is_open) {
  if (!value) {
    value = limit;
    open = is_open;
  } else if (*value != limit || open != is_open) {
    varies = true;
  }
}

Range KeyRecorder::Limits::range() const {
  Range out;
  if (!min.varies && std::isfinite(*min.value)) {
    out.min = *min.value;
    out.open_min = min.open;
  }
  if (!max.varies && std::isfinite(*max.value)) {
    out.max = *max.value;
    out.open_max = max.open;
  }
  return out;
}

KeyRecorder::Record& KeyRecorder::at(const std::string& key) { return records_[pattern_of(key)]; }

std::uint64_t KeyRecorder::choice(const std::string& key, std::string_view what) const {
  return hash_of(run_, key, what);
}

void KeyRecorder::begin_run() {
  ++run_;
  absent_.clear();
  demanded_.clear();
  read_.clear();
  maps_.clear();
}

void KeyRecorder::end_run() {
  for (const std::string& key : absent_) {
    Record& record = at(key);
    (demanded_.contains(key) ? record.was_demanded : record.was_optional) = true;
  }
  // A key that was not asked for may be absent.
  for (const auto& [map, words] : maps_) {
    for (const std::string& word : words) {
      const std::string key = map.empty() ? word : map + "." + word;
      if (!read_.contains(key)) at(key).was_optional = true;
    }
  }
}

bool KeyRecorder::is_present(const std::string& key) {
  // Each map has its own share of keys: with few, alternatives meet alone.
  constexpr std::array<std::uint64_t, 5> kShares = {15, 40, 60, 80, 95};
  const std::size_t dot = key.rfind('.');
  const std::string around = dot == std::string::npos ? "" : key.substr(0, dot);
  const bool present =
      choice(key, "present") % 100 < kShares.at(choice(around, "share") % kShares.size());
  at(key);
  read_.insert(key);
  if (!present) absent_.insert(key);
  return present;
}

std::size_t KeyRecorder::form(const std::string& key) const { return choice(key, "form") % 3; }

void KeyRecorder::demand(const std::string& key) { demanded_.insert(key); }

double KeyRecorder::number(const std::string& key, const Range& range) {
  auto& limits = at(key).number;
  if (!limits) limits = Limits{};
  limits->min.merge(range.min, range.open_min);
  limits->max.merge(range.max, range.open_max);
  // Sizes of a cell, away from the ends.
  const double low = std::max(range.min, -1.0);
  const double high = std::max(low, std::min(range.max, low + 2));
  const double share = 0.05 + 0.9 * static_cast<double>(choice(key, "number") % 1024) / 1024;
  return low + share * (high - low);
}

std::int64_t KeyRecorder::integer(const std::string& key, std::int64_t min, std::int64_t max) {
  auto& limits = at(key).integer;
  if (!limits) limits = Limits{};
  const auto as_limit = [](std::int64_t value) {
    const bool is_open = value == INT64_MIN || value == INT64_MAX;
    return is_open ? std::copysign(HUGE_VAL, static_cast<double>(value))
                   : static_cast<double>(value);
  };
  limits->min.merge(as_limit(min), false);
  limits->max.merge(as_limit(max), false);
  const std::int64_t most = max > min && max - min < 20 ? max - min + 1 : 20;
  return min + static_cast<std::int64_t>(choice(key, "integer") % static_cast<std::uint64_t>(most));
}

bool KeyRecorder::boolean(const std::string& key) {
  at(key).is_boolean = true;
  return choice(key, "boolean") % 2 == 0;
}

std::string KeyRecorder::text(const std::string& key) {
  Record& record = at(key);
  record.is_text = true;
  if (!record.words.empty()) return record.words[choice(key, "text") % record.words.size()];
  constexpr std::array<std::string_view, 8> kTexts = {kName, kName, kName, kName,
                                                      kName, "1",   "2",   "none"};
  return std::string(kTexts.at(choice(key, "text") % kTexts.size()));
}

std::size_t KeyRecorder::word(const std::string& key, std::span<const std::string_view> words) {
  Record& record = at(key);
  record.is_text = true;
  for (const std::string_view word : words) add(record.words, word);
  return choice(key, "word") % words.size();
}

std::size_t KeyRecorder::list(const std::string& key, std::size_t min, std::size_t max) {
  Record& record = at(key);
  record.is_list = true;
  record.min_items = min;
  record.max_items = max;
  return min + choice(key, "count") % (max - min + 1);
}

std::size_t KeyRecorder::items(const std::string& key) {
  at(key).is_list = true;
  constexpr std::array<std::size_t, 5> kCounts = {1, 2, 3, 5, 7};
  return kCounts.at(choice(key, "items") % kCounts.size());
}

void KeyRecorder::map(const std::string& key, std::span<const std::string_view> known) {
  Record& record = at(key);
  record.is_map = true;
  for (const std::string_view word : known) add(record.keys, word);
  if (!absent_.contains(key)) maps_.insert_or_assign(key, record.keys);
}

std::string KeyRecorder::name(const std::string& key) {
  Record& record = at(key);
  record.has_names = true;
  at(key.empty() ? "*" : key + ".*");
  if (!record.names.empty()) return record.names[choice(key, "name") % record.names.size()];
  constexpr std::array<std::string_view, 6> kNames = {kName, kName, kName, kName, "1", "2"};
  return std::string(kNames.at(choice(key, "name") % kNames.size()));
}

void KeyRecorder::note_words(const std::string& key, std::span<const std::string> words) {
  for (const std::string& word : words) add(at(key).words, word);
}

void KeyRecorder::note_names(const std::string& key, std::span<const std::string> names) {
  for (const std::string& name : names) add(at(key).names, name);
}

void KeyRecorder::fallback(const std::string& key, const std::string& text) {
  Record& record = at(key);
  record.fallback_varies |= record.fallback && *record.fallback != text;
  record.fallback = text;
}

KeySchema KeyRecorder::schema() const { return schema_of(""); }

KeySchema KeyRecorder::schema_of(const std::string& key) const {
  const auto found = records_.find(key);
  if (found == records_.end()) return {};
  const Record& record = found->second;
  KeySchema out{.is_text = record.is_text,
                .is_boolean = record.is_boolean,
                .is_map = record.is_map || record.has_names,
                .words = record.words,
                .min_items = record.min_items,
                .max_items = record.max_items,
                .names = record.names};
  if (record.number) out.number = record.number->range();
  if (record.integer) out.integer = record.integer->range();
  if (!record.fallback_varies) out.fallback = record.fallback;
  out.is_required = record.was_demanded && !record.was_optional;
  if (record.is_list) out.items.push_back(schema_of(key + "[]"));
  const std::string prefix = key.empty() ? "" : key + ".";
  if (record.has_names) out.values.push_back(schema_of(prefix + "*"));
  for (const std::string& word : record.keys) out.keys.push_back({word, schema_of(prefix + word)});
  return out;
}

}  // namespace aprsim::yaml
