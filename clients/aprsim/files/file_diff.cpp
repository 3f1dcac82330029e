#include "clients/aprsim/files/file_diff.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "clients/aprsim/files/json_schema.hpp"
#include "world/base/yaml/yaml_tree.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::client {
namespace {

using yaml::KeySchema;
using yaml::detail::Value;
using Kind = Difference::Kind;

/// The unit that a key ends with; longer endings first.
std::string unit_of(std::string_view key) {
  using Ending = std::pair<std::string_view, std::string_view>;
  constexpr std::array<Ending, 21> kEndings = {
      {{"_rad_s2", "rad/s2"}, {"_rad_s", "rad/s"},  {"_m_s2", "m/s2"},
       {"_m_s", "m/s"},       {"_kg_m3", "kg/m3"},  {"_kg_m2", "kg m2"},
       {"_ns_m", "N s/m"},    {"_n_ms", "N/(m s)"}, {"_n_m", "N/m"},
       {"_l_min", "l/min"},   {"_per_s", "1/s"},    {"_mm2", "mm2"},
       {"_kpa", "kPa"},       {"_bar", "bar"},      {"_deg", "deg"},
       {"_hz", "Hz"},         {"_kg", "kg"},        {"_mm", "mm"},
       {"_px", "px"},         {"_m", "m"},          {"_s", "s"}}};
  const auto* const found = std::ranges::find_if(
      kEndings, [&](const Ending& ending) { return key.ends_with(ending.first); });
  if (found != kEndings.end()) return std::string(found->second);
  return key.ends_with("_n") ? "N" : "";
}

std::optional<double> number_of(const Value& value) {
  if (value.kind != Value::Kind::kScalar || value.quoted) return std::nullopt;
  double number = 0;
  const char* end = value.scalar.data() + value.scalar.size();
  const auto read = std::from_chars(value.scalar.data(), end, number);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return number;
}

std::string shown(const Value& value) {
  std::string text = yaml::detail::write(value);
  while (text.ends_with('\n')) text.pop_back();
  for (auto at = text.find('\n'); at != std::string::npos; at = text.find('\n')) {
    const auto next = text.find_first_not_of(' ', at + 1);
    text.replace(at, next - at, text[at - 1] == ':' ? " " : "; ");
  }
  return text;
}

/// The name of an entry of a list; empty if it has none.
std::string name_of(const Value& value) {
  const yaml::detail::Entry* name = value.find("name");
  return name == nullptr ? "" : name->value.scalar;
}

bool all_named(const Value& list) {
  return list.kind == Value::Kind::kList && !list.items.empty() &&
         std::ranges::none_of(list.items, [](const Value& item) { return name_of(item).empty(); });
}

std::string joined(const std::string& key, const std::string& part) {
  return key.empty() ? part : key + '.' + part;
}

class Comparison {
 public:
  void compare(const Value& before, const Value& after, const std::string& key,
               const KeySchema* schema) {
    if (before.kind == Value::Kind::kMap && after.kind == Value::Kind::kMap) {
      compare_maps(before, after, key, schema);
    } else if (is_list(before) && is_list(after) && (all_named(before) || all_named(after)) &&
               (all_named(before) || before.items.empty()) &&
               (all_named(after) || after.items.empty())) {
      compare_named(before, after, key, schema);
    } else if (!same(before, after)) {
      add(Kind::kChanged, key, shown(before), shown(after));
    }
  }

  std::vector<Difference> differences;

 private:
  static bool is_list(const Value& value) { return value.kind == Value::Kind::kList; }

  static bool same(const Value& a, const Value& b) {
    if (a.kind != b.kind || a.items.size() != b.items.size()) return false;
    if (const auto x = number_of(a), y = number_of(b); x && y) return *x == *y;
    if (a.scalar != b.scalar || a.entries.size() != b.entries.size()) return false;
    for (std::size_t i = 0; i < a.items.size(); ++i) {
      if (!same(a.items[i], b.items[i])) return false;
    }
    return std::ranges::all_of(a.entries, [&](const yaml::detail::Entry& entry) {
      const yaml::detail::Entry* other = b.find(entry.key);
      return other != nullptr && same(entry.value, other->value);
    });
  }

  void add(Kind kind, const std::string& key, std::string before, std::string after) {
    const std::string last = key.substr(key.rfind('.') + 1);
    differences.push_back({.kind = kind,
                           .key = key,
                           .before = std::move(before),
                           .after = std::move(after),
                           .unit = unit_of(last)});
  }

  /// Whether a value that only one file has is the default.
  static bool is_default(const Value& value, const KeySchema* schema) {
    if (schema == nullptr) return false;
    if (value.kind == Value::Kind::kMap || value.kind == Value::Kind::kList) {
      const bool empty = value.entries.empty() && value.items.empty();
      const bool all = value.kind == Value::Kind::kMap && schema->values.empty() &&
                       std::ranges::all_of(value.entries, [&](const auto& entry) {
                         const yaml::KeyEntry* inner = schema->find(entry.key);
                         return inner != nullptr && is_default(entry.value, &inner->value);
                       });
      return !schema->is_required && (empty || all);
    }
    return schema->fallback && same(value, scalar_of(*schema->fallback));
  }

  static Value scalar_of(const std::string& text) {
    return {.kind = Value::Kind::kScalar, .scalar = text};
  }

  static const KeySchema* below(const KeySchema* schema, const std::string& key) {
    if (schema == nullptr) return nullptr;
    if (const yaml::KeyEntry* entry = schema->find(key)) return &entry->value;
    return schema->values.empty() ? nullptr : &schema->values.front();
  }

  void compare_maps(const Value& before, const Value& after, const std::string& key,
                    const KeySchema* schema) {
    for (const auto& entry : before.entries) {
      const KeySchema* inner = below(schema, entry.key);
      const yaml::detail::Entry* other = after.find(entry.key);
      if (other != nullptr) {
        if (!compare_places(entry, other->value, key)) {
          compare(entry.value, other->value, joined(key, entry.key), inner);
        }
      } else {
        one_sided(Kind::kRemoved, entry.value, joined(key, entry.key), inner);
      }
    }
    for (const auto& entry : after.entries) {
      if (before.find(entry.key) != nullptr) continue;
      one_sided(Kind::kAdded, entry.value, joined(key, entry.key), below(schema, entry.key));
    }
  }

  /// Things of a list one by one, anything else as a whole.
  void one_sided(Kind kind, const Value& value, const std::string& key, const KeySchema* schema) {
    if (is_default(value, schema)) return;
    const KeySchema* inner =
        schema == nullptr || schema->items.empty() ? nullptr : &schema->items.front();
    if (all_named(value)) {
      for (const Value& item : value.items) {
        one_sided(kind, item, joined(key, name_of(item)), inner);
      }
      return;
    }
    const bool added = kind == Kind::kAdded;
    add(kind, key, added ? "" : shown(value), added ? shown(value) : "");
  }

  void compare_named(const Value& before, const Value& after, const std::string& key,
                     const KeySchema* schema) {
    const KeySchema* inner =
        schema == nullptr || schema->items.empty() ? nullptr : &schema->items.front();
    const auto named = [](const Value& list, const std::string& name) {
      const auto it = std::ranges::find(list.items, name, name_of);
      return it == list.items.end() ? nullptr : &*it;
    };
    for (const Value& item : before.items) {
      const std::string name = name_of(item);
      if (const Value* other = named(after, name)) {
        compare(item, *other, joined(key, name), inner);
      } else {
        one_sided(Kind::kRemoved, item, joined(key, name), inner);
      }
    }
    for (const Value& item : after.items) {
      const std::string name = name_of(item);
      if (!named(before, name)) one_sided(Kind::kAdded, item, joined(key, name), inner);
    }
  }

  /// Positions, with the distance between them.
  bool compare_places(const yaml::detail::Entry& before, const Value& after,
                      const std::string& key) {
    if (before.key != "xyz_m" && before.key != "xy_m") return false;
    if (same(before.value, after)) return true;
    const auto& a = before.value.items;
    if (a.empty() || a.size() != after.items.size()) return false;
    double square = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const auto x = number_of(a[i]), y = number_of(after.items[i]);
      if (!x || !y) return false;
      square += (*y - *x) * (*y - *x);
    }
    add(Kind::kMoved, joined(key, before.key), shown(before.value), shown(after));
    differences.back().moved_m = std::sqrt(square);
    return true;
  }
};

/// The tree of all that a file describes.
Outcome<Value> tree_of(const FoundFile& file, const scene::DataPaths& paths) {
  auto text = file.kind == FileKind::kScene ? scene::self_contained(file.path, paths)
                                            : Result<std::string>(file.text);
  if (!text) return failed(FailureKind::kUsage, text.error().message);
  auto tree = yaml::detail::parse(*text, file.path);
  if (!tree) return failed(FailureKind::kUsage, tree.error().message);
  return *std::move(tree);
}

}  // namespace

Outcome<std::vector<Difference>> diff_files(const FoundFile& before, const FoundFile& after,
                                            const scene::DataPaths& paths) {
  const auto a = tree_of(before, paths), b = tree_of(after, paths);
  if (!a) return tl::unexpected(a.error());
  if (!b) return tl::unexpected(b.error());
  const KeySchema& schema = keys_of(before.kind);
  Comparison comparison;
  comparison.compare(*a, *b, "", &schema);
  return std::move(comparison.differences);
}

std::string text_of(const Difference& difference) {
  const std::string unit = difference.unit.empty() ? "" : ' ' + difference.unit;
  switch (difference.kind) {
    case Kind::kAdded:
      return fmt::format("+ {}: {}{}", difference.key, difference.after, unit);
    case Kind::kRemoved:
      return fmt::format("- {}: {}{}", difference.key, difference.before, unit);
    case Kind::kMoved:
      return fmt::format("~ {}: {} -> {}{}, moved by {:.4g} mm", difference.key, difference.before,
                         difference.after, unit, 1e3 * difference.moved_m);
    case Kind::kChanged:
      break;
  }
  return fmt::format("~ {}: {} -> {}{}", difference.key, difference.before, difference.after, unit);
}

}  // namespace aprsim::client
