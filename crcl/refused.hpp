#pragma once

#include <cstddef>
#include <string>

/// Common parts of all users of the XML library. Internal to the codec.
namespace aprsim::crcl {

/// Thrown through the library to abandon a document.
struct Refused {
  std::string what;
};

inline constexpr std::size_t kMaxEntityExpansions = 16;  ///< in one document

}  // namespace aprsim::crcl
