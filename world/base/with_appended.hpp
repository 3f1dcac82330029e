#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace aprsim {

/// A list that immutable snapshots share; null = empty.
template <typename T>
using SharedList = std::shared_ptr<const std::vector<T>>;

/// A copy of `list` with `item` at its end and the oldest items dropped beyond `max` >= 1. The list
/// itself does not change. Throws std::bad_alloc.
template <typename T>
[[nodiscard]] SharedList<T> with_appended(const SharedList<T>& list, T item, std::size_t max) {
  std::vector<T> all;
  all.reserve(max);
  if (list) {
    const std::size_t dropped = list->size() >= max ? list->size() - max + 1 : 0;
    all.assign(list->begin() + static_cast<std::ptrdiff_t>(dropped), list->end());
  }
  all.push_back(std::move(item));
  return std::make_shared<const std::vector<T>>(std::move(all));
}

}  // namespace aprsim
