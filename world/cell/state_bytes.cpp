#include "world/cell/state_bytes.hpp"

#include <new>

#include "world/api/snapshot/snapshot_fields.hpp"
#include "world/archive/archive.hpp"

namespace aprsim::world {

std::string to_bytes(const WorldState& state) {
  std::string bytes;
  archive::Writer out(bytes);
  out(state);
  return bytes;
}

Result<WorldState> from_bytes(std::string_view bytes, const WorldState& like) {
  WorldState state = like;
  try {
    archive::Reader in(bytes);
    in(state);
    in.finish();
  } catch (const archive::Damaged& failure) {
    return fail(ErrorCode::kInvalidArgument, "state",
                "the saved state cannot be read: " + std::string(failure.what()));
  }
  return state;
}

}  // namespace aprsim::world
