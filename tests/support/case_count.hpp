#pragma once

#include <cstdlib>

namespace aprsim::test {

/// Number of random cases of a sweep: all of them where APRSIM_THOROUGH is set in the environment,
/// as tests/checks does, else the first fifth.
inline int case_count(int all) {
  return std::getenv("APRSIM_THOROUGH") != nullptr ? all : (all + 4) / 5;
}

}  // namespace aprsim::test
