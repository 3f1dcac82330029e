#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "world/base/yaml/yaml_reader.hpp"

/// The keys of a kind of file, learned from its readers. They read Document::recorded() many times,
/// which gives each key another value, or none, each time. A limit, default or requirement is kept
/// if it holds whatever the rest of the file says.
namespace aprsim::yaml {

struct KeyEntry;

/// A value in a file, with all forms that readers accept.
struct KeySchema {
  bool is_text = false, is_boolean = false;
  bool is_map = false;                   ///< with `keys`, and no others unless `values` has one
  std::vector<std::string> words;        ///< texts that are accepted; empty = any, if is_text
  std::optional<Range> number, integer;  ///< limits of numbers
  std::vector<KeySchema> items;          ///< of a list: one element, what each item is
  std::size_t min_items = 0;             ///< shortest list
  std::size_t max_items = SIZE_MAX;      ///< longest list
  std::vector<KeyEntry> keys;            ///< of a map, in the readers' order
  std::vector<KeySchema> values;         ///< of a map with names of its own: one element
  std::vector<std::string> names;        ///< names that such a map may have; empty = any
  std::optional<std::string> fallback;   ///< default, as in a file
  bool is_required = false;              ///< no reader accepts a map without this key

  [[nodiscard]] const KeyEntry* find(std::string_view key) const;
};

struct KeyEntry {
  std::string key;
  KeySchema value;
};

/// Deterministic: equal readers and numbers of runs give equal schemas.
class KeyRecorder {
 public:
  void begin_run();
  void end_run();
  /// After the last run.
  [[nodiscard]] KeySchema schema() const;

  // The rest is called by Node. Keys are as in robots[2].name, and pockets.* for any name.
  [[nodiscard]] bool is_present(const std::string& key);
  /// 0 for a plain value, 1 for a list, 2 for a map.
  [[nodiscard]] std::size_t form(const std::string& key) const;
  /// An absent key that a reader demands.
  void demand(const std::string& key);
  double number(const std::string& key, const Range& range);
  std::int64_t integer(const std::string& key, std::int64_t min, std::int64_t max);
  bool boolean(const std::string& key);
  std::string text(const std::string& key);
  std::size_t word(const std::string& key, std::span<const std::string_view> words);
  std::size_t list(const std::string& key, std::size_t min, std::size_t max);
  std::size_t items(const std::string& key);
  void map(const std::string& key, std::span<const std::string_view> known);
  std::string name(const std::string& key);
  void note_words(const std::string& key, std::span<const std::string> words);
  void note_names(const std::string& key, std::span<const std::string> names);
  void fallback(const std::string& key, const std::string& text);

 private:
  /// A bound that is the same in all runs, or none.
  struct Bound {
    std::optional<double> value;
    bool open = false, varies = false;
    void merge(double limit, bool is_open);
  };
  struct Limits {
    Bound min, max;
    [[nodiscard]] Range range() const;
  };
  struct Record {
    bool is_text = false, is_boolean = false, is_list = false, is_map = false, has_names = false;
    std::vector<std::string> words, keys, names;
    std::optional<Limits> number, integer;
    std::size_t min_items = 0, max_items = SIZE_MAX;
    std::optional<std::string> fallback;
    bool fallback_varies = false, was_demanded = false, was_optional = false;
  };

  Record& at(const std::string& key);
  [[nodiscard]] std::uint64_t choice(const std::string& key, std::string_view what) const;
  [[nodiscard]] KeySchema schema_of(const std::string& key) const;

  std::uint64_t run_ = 0;
  std::map<std::string, Record> records_;
  // In this run: keys that are absent, without which there is an error, that were asked for; and
  // the known keys of the maps that are present.
  std::set<std::string> absent_, demanded_, read_;
  std::map<std::string, std::vector<std::string>> maps_;
};

}  // namespace aprsim::yaml
