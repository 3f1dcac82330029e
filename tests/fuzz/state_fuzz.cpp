// The bytes choose a genuine state and changes of its fields; the result must be refused or run.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/support/state_mutation.hpp"

namespace {

const std::vector<aprsim::test::GenuineState>& states() {
  static const std::vector<aprsim::test::GenuineState> all = aprsim::test::genuine_states();
  return all;
}

}  // namespace

// Makes the states before the first input, whose time counts.
extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  static_cast<void>(states());
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace aprsim::test;
  std::size_t at = 0;
  // Four bytes a number; zero when they are used up.
  const auto draw = [&] {
    std::uint64_t number = 0;
    for (int i = 0; i < 4 && at < size; ++i) number = number << 8 | data[at++];
    return number;
  };
  const GenuineState& state = states()[draw() % states().size()];
  static_cast<void>(survives(state, mutated(state, draw), 5));
  return 0;
}
