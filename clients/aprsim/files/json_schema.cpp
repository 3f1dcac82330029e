#include "clients/aprsim/files/json_schema.hpp"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>

#include "world/scenario/scenario_reader.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::client {
namespace {

using Json = nlohmann::ordered_json;
using yaml::KeySchema;

/// A limit as a whole number if it is one.
Json number_json(double value) {
  constexpr double kExact = 9e15;
  if (std::nearbyint(value) == value && std::abs(value) < kExact) {
    return static_cast<std::int64_t>(value);
  }
  return value;
}

Json range_json(const char* type, const yaml::Range& range) {
  Json out = {{"type", type}};
  if (std::isfinite(range.min)) {
    out[range.open_min ? "exclusiveMinimum" : "minimum"] = number_json(range.min);
  }
  if (std::isfinite(range.max)) {
    out[range.open_max ? "exclusiveMaximum" : "maximum"] = number_json(range.max);
  }
  return out;
}

/// A default as the type that the value has.
Json fallback_json(const KeySchema& keys) {
  const std::string& text = *keys.fallback;
  if (keys.is_boolean && (text == "true" || text == "false")) return text == "true";
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_number = read.ec == std::errc() && read.ptr == text.data() + text.size();
  if (is_number && (keys.number || keys.integer)) return number_json(value);
  return text;
}

class Writer {
 public:
  explicit Writer(FileKind kind) : kind_(kind) {}

  [[nodiscard]] Json value(const KeySchema& keys, const std::string& pattern) const {
    Json forms = Json::array();
    if (keys.is_text) forms.push_back(text(keys));
    if (keys.is_boolean) forms.push_back({{"type", "boolean"}});
    const bool any_scalar = keys.is_text && keys.words.empty();
    if (keys.integer && !any_scalar) forms.push_back(range_json("integer", *keys.integer));
    if (keys.number && !any_scalar) forms.push_back(range_json("number", *keys.number));
    if (!keys.items.empty()) forms.push_back(list(keys, pattern));
    if (keys.is_map) forms.push_back(map(keys, pattern));
    Json out = Json::object();
    if (const std::string meaning = meaning_of(kind_, pattern); !meaning.empty()) {
      out["description"] = meaning;
    }
    if (keys.fallback && !keys.fallback->empty()) out["default"] = fallback_json(keys);
    if (forms.size() == 1) {
      out.update(forms.front());
    } else if (!forms.empty()) {
      out["anyOf"] = forms;
    }
    return out;
  }

 private:
  /// Plain scalars are texts for the readers, too.
  static Json text(const KeySchema& keys) {
    if (!keys.words.empty()) return {{"enum", keys.words}};
    return {{"type", {"string", "number", "boolean"}}};
  }

  [[nodiscard]] Json list(const KeySchema& keys, const std::string& pattern) const {
    Json out = {{"type", "array"}, {"items", value(keys.items.front(), pattern + "[]")}};
    if (keys.min_items > 0) out["minItems"] = keys.min_items;
    if (keys.max_items < std::numeric_limits<std::size_t>::max()) out["maxItems"] = keys.max_items;
    return out;
  }

  [[nodiscard]] Json map(const KeySchema& keys, const std::string& pattern) const {
    const std::string prefix = pattern.empty() ? "" : pattern + ".";
    Json out = {{"type", "object"}};
    Json required = Json::array();
    for (const auto& [key, inner] : keys.keys) {
      out["properties"][key] = value(inner, prefix + key);
      if (inner.is_required) required.push_back(key);
    }
    if (keys.values.empty()) {
      out["additionalProperties"] = false;
    } else if (keys.names.empty()) {
      out["additionalProperties"] = value(keys.values.front(), prefix + "*");
    } else {
      for (const std::string& name : keys.names) {
        out["properties"][name] = value(keys.values.front(), prefix + "*");
      }
      out["additionalProperties"] = false;
    }
    if (!required.empty()) out["required"] = required;
    return out;
  }

  FileKind kind_;
};

const char* title_of(FileKind kind) {
  switch (kind) {
    case FileKind::kScene:
      return "Scene of aprsim";
    case FileKind::kTypes:
      return "Types of parts, trays and robots of aprsim";
    case FileKind::kScenario:
      return "Scenario of aprsim";
  }
  return "";
}

}  // namespace

const KeySchema& keys_of(FileKind kind) {
  // Recorded once: it takes a moment.
  if (kind == FileKind::kScenario) {
    static const KeySchema scenario = scenario::scenario_keys();
    return scenario;
  }
  if (kind == FileKind::kTypes) {
    static const KeySchema types = scene::type_keys();
    return types;
  }
  static const KeySchema scene = scene::scene_keys();
  return scene;
}

Json json_schema(FileKind kind) {
  Json out = {{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", title_of(kind)}};
  out.update(Writer(kind).value(keys_of(kind), ""));
  return out;
}

}  // namespace aprsim::client
