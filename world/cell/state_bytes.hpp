#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "world/archive/layout.hpp"
#include "world/base/result.hpp"
#include "world/cell/world_state.hpp"

namespace aprsim::world {

/// Version of the layout of the bytes below: rises with every change of the state's members. Bytes
/// of another version cannot be read.
inline constexpr std::uint32_t kStateVersion = 12;

/// A saved state as bytes, complete and bit for bit. `layout`, if given, receives the places of its
/// numbers. Thread: any.
[[nodiscard]] std::string to_bytes(const WorldState& state, archive::Layout* layout = nullptr);

/// Reads a state from bytes that may come from anywhere. `like`: any state of a world of the same
/// scene, which gives the constants. Every number is checked against that world
/// (world/archive/archive.hpp). Errors: kInvalidArgument with the value that the world cannot have.
/// Thread: any.
[[nodiscard]] Result<WorldState> from_bytes(std::string_view bytes, const WorldState& like);

/// The same state for a world with other constants, as after a change of a scene's value. Errors:
/// kInvalidArgument where that world has other parts. Thread: any.
[[nodiscard]] Result<WorldState> with_constants_of(const WorldState& like, const WorldState& state);

}  // namespace aprsim::world
