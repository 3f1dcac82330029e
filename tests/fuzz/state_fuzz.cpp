// The bytes choose a genuine state and changes of its fields; the result must be refused or run.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/support/state_mutation.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace aprsim::test;
  static const std::vector<GenuineState> states = genuine_states();
  std::size_t at = 0;
  // Four bytes a number; zero when they are used up.
  const auto draw = [&] {
    std::uint64_t number = 0;
    for (int i = 0; i < 4 && at < size; ++i) number = number << 8 | data[at++];
    return number;
  };
  const GenuineState& state = states[draw() % states.size()];
  static_cast<void>(survives(state, mutated(state, draw), 5));
  return 0;
}
