#include "server/journal/state_files.hpp"

#include <exception>
#include <utility>

#include <fmt/format.h>

#include "proto/journal/journal_reader.hpp"
#include "server/journal/run_header.hpp"
#include "world/state_bytes.hpp"

namespace aprsim::server::journal {
namespace {

tl::unexpected<Error> refused(std::string why) {
  return fail(ErrorCode::kFailedPrecondition, "file", std::move(why));
}

/// Why states of one header mean nothing under the other; empty = they do.
std::string mismatch(const v1::JournalHeader& file, const v1::JournalHeader& here) {
  if (file.scene() != here.scene()) {
    return fmt::format("it is of scene '{}', and this cell is '{}'", file.scene(), here.scene());
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
  if (file.state_version() != here.state_version()) {
    return fmt::format(
        "its state has layout {}, written by version {}, and this program reads layout {}",
        file.state_version(), file.version(), here.state_version());
  }
  return {};
}

}  // namespace

Result<void> SceneStateFiles::prepare() {
  if (world_) return {};
  auto header = header_of(*scene_);
  if (!header) return tl::unexpected(header.error());
  header_ = std::move(*header);
  header_.set_version(version_);
  header_.set_part(1);
  try {
    world_ = std::make_unique<world::World>(scene_, scene_->seed);
  } catch (const std::exception& failure) {
    return fail(ErrorCode::kUnavailable, "file", failure.what());
  }
  return {};
}

Result<std::string> SceneStateFiles::write(const std::string& name, const api::StatePtr& state) {
  const std::lock_guard lock(mutex_);
  if (auto ready = prepare(); !ready) return tl::unexpected(ready.error());
  world_->restore(*state);
  aprsim::journal::FrameEncoder encoder;
  v1::JournalRecord record;
  *record.mutable_header() = header_;
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
  checkpoint.set_hash(world_->state_hash());
  encoder.add(record);
  record.mutable_end()->mutable_time()->set_step(state->steps);
  encoder.add(record);
  return std::string(aprsim::journal::kMagic) + encoder.take();
}

Result<protocols::StateFiles::Read> SceneStateFiles::read(std::string bytes) {
  auto reader = aprsim::journal::JournalReader::of_bytes(std::move(bytes));
  if (!reader) return fail(reader.error().code, "file", reader.error().message);
  const std::lock_guard lock(mutex_);
  if (auto ready = prepare(); !ready) return tl::unexpected(ready.error());
  if (const std::string why = mismatch(reader->header(), header_); !why.empty()) {
    return refused("the state cannot be taken: " + why);
  }
  std::string name;
  for (v1::JournalRecord record; reader->next(record);) {
    if (record.has_epoch()) name = record.epoch().loaded_state();
    if (!record.has_checkpoint()) continue;
    auto state = world::from_bytes(record.checkpoint().state(), world_->save());
    if (!state) return fail(state.error().code, "file", state.error().message);
    try {
      world_->restore(*state);
    } catch (const std::exception& failure) {
      world_.reset();
      return fail(ErrorCode::kInvalidArgument, "file",
                  "the state cannot be restored: " + std::string(failure.what()));
    }
    if (world_->state_hash() != record.checkpoint().hash()) {
      return fail(ErrorCode::kInvalidArgument, "file",
                  "damaged: its state is not the one that was saved");
    }
    return Read{name, std::make_shared<const world::WorldState>(std::move(*state))};
  }
  return fail(ErrorCode::kInvalidArgument, "file",
              reader->damage().empty() ? "it holds no state" : reader->damage());
}

}  // namespace aprsim::server::journal
