#include "server/journal/recorded_scenes.hpp"

#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <span>
#include <utility>

#include "server/journal/digest.hpp"
#include "world/cell/state_bytes.hpp"
#include "world/devices/device_group.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server::journal {

namespace fs = std::filesystem;

namespace {

/// A scene's file has at most 1 MiB; its types come on top.
constexpr std::size_t kMaxTextBytes = std::size_t{4} << 20;

}  // namespace

RecordedScenes::RecordedScenes(ScenePtr scene, std::string directory)
    : header_(std::move(scene)),
      header_models_(world::load_models(*header_)),
      directory_(fs::path(header_->file).parent_path().string()),
      scene_directory_(std::move(directory)) {}

RecordedScenes::~RecordedScenes() {
  std::error_code ignored;
  if (removes_) fs::remove_all(scene_directory_, ignored);
}

const world::ArmModels& RecordedScenes::models_of(const ScenePtr& scene) {
  if (scene == header_) return header_models_;
  if (!models_scene_ || scene != models_scene_) {
    const scene::Scene& known = models_scene_ ? *models_scene_ : *header_;
    models_ = world::models_for(*scene, known, models_scene_ ? models_ : header_models_);
    models_scene_ = scene;
  }
  return models_;
}

/// The directory of the scene's own robot descriptions, after they are written there; that of the
/// header's where it has none.
Result<std::string> RecordedScenes::directory_of(const v1::JournalScene& message) {
  if (message.models().empty()) return directory_;
  std::string digests;
  for (const v1::JournalFile& model : message.models()) {
    if (!scene::is_plain_name(model.name())) {
      return fail(ErrorCode::kInvalidArgument, "journal",
                  "the model's name '" + model.name().substr(0, 64) + "' is not a plain name");
    }
    digests += model.name() + '\n' + sha256(model.content()) + '\n';
  }
  if (scene_directory_.empty()) {
    std::string name = (fs::temp_directory_path() / "aprsim-scenes-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) {
      return fail(ErrorCode::kUnavailable, "journal", name + " cannot be made");
    }
    scene_directory_ = std::move(name);
    removes_ = true;
  }
  const fs::path directory = fs::path(scene_directory_) / sha256(digests);
  std::error_code status;
  if (fs::is_directory(directory, status)) return directory.string();
  fs::create_directory(directory, status);
  for (const v1::JournalFile& model : message.models()) {
    std::ofstream file(directory / model.name(), std::ios::binary);
    file << model.content();
    if (!file.flush()) {
      return fail(ErrorCode::kUnavailable, "journal",
                  (directory / model.name()).string() + " cannot be written");
    }
  }
  return directory.string();
}

Result<RecordedScenes::ScenePtr> RecordedScenes::read(const v1::JournalScene& message,
                                                      ScenePtr& last) {
  if (message.text().size() > kMaxTextBytes) {
    return fail(ErrorCode::kInvalidArgument, "journal",
                "a scene has " + std::to_string(message.text().size()) + " bytes, the limit is " +
                    std::to_string(kMaxTextBytes));
  }
  if (!scene::is_plain_name(message.name())) {
    return fail(ErrorCode::kInvalidArgument, "journal",
                "a scene's name '" + message.name().substr(0, 64) + "' is not a plain name");
  }
  const auto directory = directory_of(message);
  if (!directory) return tl::unexpected(directory.error());
  const std::string file = (fs::path(*directory) / (message.name() + ".yaml")).string();
  if (last && last->text == message.text() && last->file == file) return last;
  scene::KnownFiles known = scene::files_of(*header_);
  for (const v1::JournalFile& model : message.models()) {
    known.models.push_back((fs::path(*directory) / model.name()).string());
  }
  auto scene =
      scene::read_recorded(message.text(), file, scene::default_data_paths(), std::move(known));
  if (!scene) return tl::unexpected(std::move(scene.error()));
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
      const world::World world(scene, models_of(scene), scene->seed,
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
