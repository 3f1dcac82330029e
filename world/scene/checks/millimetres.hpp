#pragma once

#include <cstdio>
#include <string>

namespace aprsim::scene {

/// A length in metres as text in millimetres, for errors.
[[nodiscard]] inline std::string mm(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g mm", metres * 1e3);
  return text;
}

}  // namespace aprsim::scene
