#pragma once

#include <string>

#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// Kind of the parts that a heap is made of.
enum class HeapParts { kGears, kTrays, kMixed };

[[nodiscard]] std::string name_of(HeapParts parts);

/// Parts at any attitude, in layers over a table, that fall and form one heap.
struct HeapPlan {
  HeapParts parts = HeapParts::kGears;
  int bodies = 100;
  bool walls = false;  ///< a bin keeps them together
  unsigned seed = 1;
};

/// The same plan, the same scene. All bodies stay awake.
[[nodiscard]] scene::Scene heap_scene(const HeapPlan& plan);

}  // namespace aprsim::bench
