#include "world/cell/state_bytes.hpp"

#include <new>

#include "world/api/snapshot/snapshot_fields.hpp"
#include "world/archive/archive.hpp"

namespace aprsim::world {
namespace {

Result<WorldState> read(archive::Reader in, const WorldState& like) try {
  WorldState state = like;
  in(state);
  in.finish();
  return state;
} catch (const archive::Damaged& failure) {
  return fail(ErrorCode::kInvalidArgument, "state",
              "the saved state cannot be read: " + std::string(failure.what()));
}

}  // namespace

std::string to_bytes(const WorldState& state, archive::Layout* layout) {
  std::string bytes;
  archive::Writer out(bytes, layout);
  out(state);
  return bytes;
}

Result<WorldState> from_bytes(std::string_view bytes, const WorldState& like) {
  return read(archive::Reader(bytes, *like.counts), like);
}

Result<WorldState> with_constants_of(const WorldState& like, const WorldState& state) {
  return read(archive::Reader(to_bytes(state)), like);
}

}  // namespace aprsim::world
