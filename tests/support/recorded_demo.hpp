#pragma once

#include <cstdint>

#include "tests/support/kitting_demo.hpp"
#include "world/runtime/record/recorder.hpp"

namespace aprsim::test {

/// The default cell at work in stepped time, told to a recorder as a simulation tells it.
class RecordedDemo {
 public:
  /// Both outlive it; the world is of the scene "aprs", with this seed, and new.
  RecordedDemo(world::World& world, world::Recorder& recorder, std::uint64_t seed);
  /// One step and the commands before it.
  void advance();

 private:
  world::World& world_;
  world::Recorder& recorder_;
  KittingDemo demo_;
  std::size_t told_ = 0;  ///< of the demo's commands
};

}  // namespace aprsim::test
