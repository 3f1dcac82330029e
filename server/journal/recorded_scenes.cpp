#include "server/journal/recorded_scenes.hpp"

#include <exception>
#include <filesystem>
#include <span>
#include <utility>

#include "server/journal/digest.hpp"
#include "world/cell/state_bytes.hpp"
#include "world/devices/device_group.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server::journal {
namespace {

/// A scene's file has at most 1 MiB; its types come on top.
constexpr std::size_t kMaxTextBytes = std::size_t{4} << 20;

}  // namespace

RecordedScenes::RecordedScenes(ScenePtr scene)
    : header_(std::move(scene)),
      models_(world::load_models(*header_)),
      directory_(std::filesystem::path(header_->file).parent_path().string()) {}

Result<RecordedScenes::ScenePtr> RecordedScenes::read(const v1::JournalScene& message,
                                                      ScenePtr& last) const {
  if (last && last->text == message.text() && last->name == message.name()) return last;
  if (message.text().size() > kMaxTextBytes) {
    return fail(ErrorCode::kInvalidArgument, "journal",
                "a scene has " + std::to_string(message.text().size()) + " bytes, the limit is " +
                    std::to_string(kMaxTextBytes));
  }
  if (!scene::is_plain_name(message.name())) {
    return fail(ErrorCode::kInvalidArgument, "journal",
                "a scene's name '" + message.name().substr(0, 64) + "' is not a plain name");
  }
  const std::string file =
      (std::filesystem::path(directory_) / (message.name() + ".yaml")).string();
  auto scene = scene::read_recorded(message.text(), file, scene::default_data_paths(),
                                    scene::files_of(*header_));
  if (!scene) return tl::unexpected(std::move(scene.error()));
  if (scene->robots.size() != header_->robots.size()) {
    return fail(ErrorCode::kInvalidArgument, "journal",
                "its scene '" + message.name() + "' has other robots than its header's");
  }
  if (auto ok = devices::check_devices(*scene, "recorded scene"); !ok) {
    return tl::unexpected(ok.error());
  }
  last = std::make_shared<const scene::Scene>(*std::move(scene));
  return last;
}

Result<RecordedScenes::ScenePtr> RecordedScenes::scene_of(const v1::JournalEpoch& epoch) {
  if (!epoch.has_scene()) return header_;
  return read(epoch.scene(), base_);
}

Result<world::WorldState> RecordedScenes::state_of(const v1::JournalCheckpoint& checkpoint) {
  const std::string& digest = checkpoint.state_sha256();
  if (!digest.empty() && digest != sha256(checkpoint.state())) {
    return fail(ErrorCode::kInvalidArgument, "journal",
                "damaged: the digest of a checkpoint's state is wrong");
  }
  ScenePtr scene = header_, base;
  if (checkpoint.has_scene()) {
    auto other = read(checkpoint.scene(), base_);
    if (!other) return tl::unexpected(other.error());
    scene = *other;
  }
  if (checkpoint.has_changed_scene()) {
    auto changed = read(checkpoint.changed_scene(), changed_);
    if (!changed) return tl::unexpected(changed.error());
    base = std::exchange(scene, *changed);
  }
  if (!like_ || like_->scene != scene) {
    try {
      const world::World world(scene, models_, scene->seed,
                               std::span<robot::PlanPrefetcher* const>());
      like_ = std::make_unique<const world::WorldState>(world.save());
    } catch (const std::exception& failure) {
      return fail(ErrorCode::kInvalidArgument, "journal",
                  "the scene of a checkpoint cannot be built: " + std::string(failure.what()));
    }
  }
  auto state = world::from_bytes(checkpoint.state(), *like_);
  if (state) state->base = base;
  return state;
}

}  // namespace aprsim::server::journal
