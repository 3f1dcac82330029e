#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "tests/support/kitting_demo.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::test {

inline constexpr int kHashPeriod = 10;  ///< steps
inline constexpr double kHashPeriodS = 0.01;

/// The state's hash every kHashPeriod steps, and how it came about.
struct Trace {
  std::vector<std::uint64_t> hashes;
  std::vector<int> trips;  ///< made by both robots so far; of a recorded trace only
  std::vector<TimedCommand> commands;
};

/// Runs the KittingDemo in a new world of that scene.
Trace record_demo(const std::shared_ptr<const scene::Scene>& scene, double seconds);

/// Applies the commands of `trace` at their steps to a new world, whose state is saved in the
/// middle and loaded into another one, which goes on.
Trace replay_demo(const std::shared_ptr<const scene::Scene>& scene, const Trace& trace);

/// Hashes that differ; those that only one trace has count too.
int count_mismatches(const Trace& a, const Trace& b);

}  // namespace aprsim::test
