#pragma once

#include <cstddef>
#include <type_traits>
#include <vector>

namespace aprsim::archive {

/// The places of the numbers and lists in the bytes that a Writer has written.
struct Layout {
  enum class Kind {
    kTruth,
    kEnumerator,
    kInteger,
    kReal,
    kCount,  ///< of a list's or a text's elements
    kTag,    ///< of a variant's type or a shared value
  };
  struct Leaf {
    std::size_t at = 0, size = 0;  ///< in the bytes
    Kind kind = Kind::kInteger;
  };
  struct List {
    std::size_t count_at = 0;
    std::vector<std::size_t> begins;  ///< of the elements, then the end of the last one
  };

  template <typename T>
  [[nodiscard]] static constexpr Kind kind_of() {
    if constexpr (std::is_same_v<T, bool>) {
      return Kind::kTruth;
    } else if constexpr (std::is_enum_v<T>) {
      return Kind::kEnumerator;
    } else {
      return std::is_floating_point_v<T> ? Kind::kReal : Kind::kInteger;
    }
  }

  std::vector<Leaf> leaves;
  std::vector<List> lists;
};

}  // namespace aprsim::archive
