#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "world/archive/layout.hpp"
#include "world/cell/world.hpp"

/// Genuine states of cells at work, and wrong ones made of them field by field.
namespace aprsim::test {

/// A state with its bytes and their fields.
struct GenuineState {
  std::string name;
  std::string bytes;
  archive::Layout layout;
  world::WorldState state;
  std::shared_ptr<world::World> world;  ///< of its scene; restore() before use
};

/// States with motions under way, plans, guards, faults of all targets, held and sleeping parts,
/// tool changes and deferred commands, of several scenes and modes of simplification.
[[nodiscard]] std::vector<GenuineState> genuine_states();

/// Draws a number; whatever decides on the mutations.
using Draw = std::function<std::uint64_t()>;
/// The bytes with one to four fields changed: numbers, enumerators, counts, tags, list elements.
[[nodiscard]] std::string mutated(const GenuineState& state, const Draw& draw);

/// Reads the bytes as a state as an import does, and, if they are accepted, runs the cell from
/// there for some steps. False: they were refused.
bool survives(const GenuineState& state, const std::string& bytes, int steps);

}  // namespace aprsim::test
