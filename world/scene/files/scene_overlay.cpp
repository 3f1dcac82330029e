#include "world/scene/files/scene_overlay.hpp"

#include <algorithm>
#include <utility>

namespace aprsim::scene {
namespace {

using yaml::detail::Value;

const std::string* name_of(const Value& value) {
  if (value.kind != Value::Kind::kMap) return nullptr;
  const yaml::detail::Entry* name = value.find("name");
  return name == nullptr ? nullptr : &name->value.scalar;
}

bool is_named_list(const Value& value) {
  return value.kind == Value::Kind::kList && !value.items.empty() &&
         std::ranges::all_of(value.items, [](const Value& item) { return name_of(item); });
}

void lay_items_over(Value& base, Value over) {
  for (Value& item : over.items) {
    const auto same = std::ranges::find_if(
        base.items, [&item](const Value& other) { return *name_of(other) == *name_of(item); });
    if (same == base.items.end()) {
      base.items.push_back(std::move(item));
    } else {
      lay_over(*same, std::move(item));
    }
  }
}

}  // namespace

void lay_over(Value& base, Value over) {
  if (is_named_list(base) && is_named_list(over)) return lay_items_over(base, std::move(over));
  if (base.kind != Value::Kind::kMap || over.kind != Value::Kind::kMap) {
    base = std::move(over);
    return;
  }
  for (yaml::detail::Entry& entry : over.entries) {
    if (yaml::detail::Entry* same = base.find(entry.key)) {
      lay_over(same->value, std::move(entry.value));
    } else {
      base.entries.push_back(std::move(entry));
    }
  }
}

}  // namespace aprsim::scene
