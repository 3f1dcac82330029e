#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "world/base/result.hpp"
#include "world/cell/world_state.hpp"

namespace aprsim::world {

/// Of the layout of the bytes below: rises with every change of what a state has. Bytes of another
/// version cannot be read.
inline constexpr std::uint32_t kStateVersion = 6;

/// A saved state as bytes, complete and bit for bit. Thread: any.
[[nodiscard]] std::string to_bytes(const WorldState& state);

/// The state of such bytes. `like`: any state of a world of the same scene, which gives what is no
/// state but the scene's. Errors: kInvalidArgument where the bytes are damaged, or of another scene
/// as far as the numbers of its parts tell. Thread: any.
[[nodiscard]] Result<WorldState> from_bytes(std::string_view bytes, const WorldState& like);

}  // namespace aprsim::world
