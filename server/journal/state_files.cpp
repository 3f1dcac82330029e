#include "server/journal/state_files.hpp"

#include <exception>
#include <utility>

#include <fmt/format.h>

#include "proto/journal/journal_reader.hpp"
#include "server/journal/digest.hpp"
#include "server/journal/recorded_scenes.hpp"
#include "server/journal/run_header.hpp"
#include "server/journal/scene_writer.hpp"
#include "world/cell/state_bytes.hpp"

namespace aprsim::server::journal {
namespace {

/// Limit of a state's unpacked size; those of the largest cells have some 2 MB.
constexpr std::size_t kMaxUnpackedBytes = std::size_t{16} << 20;

tl::unexpected<Error> refused(std::string why) {
  return fail(ErrorCode::kFailedPrecondition, "file", std::move(why));
}

std::string other_scene(const std::string& its, const std::string& here) {
  return fmt::format("it is of scene '{}', and this cell is '{}'", its, here);
}

/// Why states of one header mean nothing under the other; empty = they do.
std::string mismatch(const v1::JournalHeader& file, const v1::JournalHeader& here) {
  if (file.scene() != here.scene()) {
    return other_scene(file.scene(), here.scene());
  }
  if (file.scene_sha256() != here.scene_sha256()) {
    return fmt::format(
        "it is of scene '{}' with the digest {:.12}, and this cell's scene of that name has "
        "{:.12}: "
        "it was changed in between",
        file.scene(), file.scene_sha256(), here.scene_sha256());
  }
  for (const v1::JournalFile& model : here.models()) {
    for (const v1::JournalFile& other : file.models()) {
      if (other.name() != model.name() || other.sha256() == model.sha256()) continue;
      return fmt::format("its robot description {} has the digest {:.12}, and this cell's {:.12}",
                         model.name(), other.sha256(), model.sha256());
    }
  }
  for (const v1::JournalFile& extension : here.extensions()) {
    for (const v1::JournalFile& other : file.extensions()) {
      if (other.name() != extension.name() || other.sha256() == extension.sha256()) continue;
      return fmt::format("its extension {} has the digest {:.12}, and this cell's {:.12}",
                         extension.name(), other.sha256(), extension.sha256());
    }
  }
  if (file.state_version() != here.state_version()) {
    return fmt::format(
        "its state has layout {}, written by version {}, and this program reads layout {}",
        file.state_version(), file.version(), here.state_version());
  }
  return {};
}

/// Where it is said only as which checkpoint of a run it is.
std::string name_of(const scene::Scene& scene, const v1::JournalCheckpoint& checkpoint) {
  return fmt::format("{}-step{}", scene.name, checkpoint.time().step());
}

}  // namespace

Result<v1::JournalHeader> SceneStateFiles::header(const scene::Scene& scene) const {
  auto header = header_of(scene);
  if (!header) return header;
  header->set_version(version_);
  header->set_part(1);
  return header;
}

const StateSeal& SceneStateFiles::seal() {
  if (!seal_) seal_.emplace(StateSeal::folder());
  return *seal_;
}

/// Throws as World does.
const world::World& SceneStateFiles::world_in(const world::WorldState& state) {
  if (!world_ || world_->scene() != state.scene) {
    world_ = std::make_unique<world::World>(state.scene, state.seed);
  }
  world_->restore(state);
  return *world_;
}

/// A state is the recorded one: a world that restores it has the recorded hash.
Result<void> SceneStateFiles::check(const world::WorldState& state,
                                    const v1::JournalCheckpoint& checkpoint) {
  const world::World& world = world_in(state);
  if (checkpoint.state_sha256().empty() || world.state_hash() != checkpoint.hash()) {
    return fail(ErrorCode::kInvalidArgument, "file",
                "damaged: its state is not the one that was saved");
  }
  return {};
}

Result<std::string> SceneStateFiles::write(const std::string& name,
                                           const api::StatePtr& state) try {
  const std::lock_guard lock(mutex_);
  const auto header = this->header(*state->base_scene());
  if (!header) return tl::unexpected(header.error());
  aprsim::journal::FrameEncoder encoder;
  v1::JournalRecord record;
  *record.mutable_header() = *header;
  record.mutable_header()->set_seed(state->seed);
  encoder.add(record);
  auto& epoch = *record.mutable_epoch();
  epoch.mutable_time()->set_step(state->steps);
  epoch.set_seed(state->seed);
  epoch.set_loaded_state(name);
  encoder.add(record);
  auto& checkpoint = *record.mutable_checkpoint();
  checkpoint.mutable_time()->set_step(state->steps);
  checkpoint.set_state(world::to_bytes(*state));
  checkpoint.set_state_sha256(sha256(checkpoint.state()));
  checkpoint.set_hash(world_in(*state).state_hash());
  SceneWriter(*header, seal()).write(*state, checkpoint);
  encoder.add(record);
  record.mutable_end()->mutable_time()->set_step(state->steps);
  encoder.add(record);
  return std::string(aprsim::journal::kMagic) + encoder.take();
} catch (const std::exception& failure) {
  return fail(ErrorCode::kUnavailable, "state",
              "the state cannot be written: " + std::string(failure.what()));
}

/// One at a time, which bounds the memory of many readers.
Result<protocols::StateFiles::Read> SceneStateFiles::read(std::string bytes) try {
  const std::lock_guard lock(mutex_);
  return read_first(std::move(bytes));
} catch (const std::exception& failure) {
  const std::lock_guard lock(mutex_);
  world_.reset();
  return fail(ErrorCode::kInvalidArgument, "file",
              "the state cannot be restored: " + std::string(failure.what()));
}

Result<protocols::StateFiles::Read> SceneStateFiles::read_first(std::string bytes) {
  auto reader = aprsim::journal::JournalReader::of_bytes(
      std::move(bytes), {.frame = kMaxUnpackedBytes, .file = kMaxUnpackedBytes});
  if (!reader) return fail(reader.error().code, "file", reader.error().message);
  const auto scene = scene_();
  const auto here = header(*scene);
  if (!here) return tl::unexpected(here.error());
  if (const std::string why = mismatch(reader->header(), *here); !why.empty()) {
    return refused("the state cannot be loaded: " + why);
  }
  RecordedScenes scenes(scene);
  std::string name;
  for (v1::JournalRecord record; reader->next(record);) {
    if (record.has_epoch()) name = record.epoch().loaded_state();
    if (!record.has_checkpoint()) continue;
    if (!accepts_foreign_ &&
        !seal().has_signed(reader->header().scene_text(), record.checkpoint())) {
      return refused(
          "the state cannot be loaded: it is not signed with the key of this daemon's user, or was "
          "changed since; a daemon started with --allow-foreign-states loads it");
    }
    auto state = scenes.state_of(record.checkpoint());
    if (!state) return fail(state.error().code, "file", state.error().message);
    if (record.checkpoint().has_scene()) {
      return refused("the state cannot be loaded: " + other_scene(state->scene->name, scene->name));
    }
    if (auto ok = check(*state, record.checkpoint()); !ok) return tl::unexpected(ok.error());
    if (name.empty()) name = name_of(*scene, record.checkpoint());
    return Read{name, std::make_shared<const world::WorldState>(std::move(*state))};
  }
  return fail(ErrorCode::kInvalidArgument, "file",
              reader->damage().empty() ? "it holds no state" : reader->damage());
}

}  // namespace aprsim::server::journal
