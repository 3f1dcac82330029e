#include "world/cell/commands/next_scene.hpp"

#include <exception>
#include <filesystem>
#include <string>
#include <utility>

#include "world/cell/world.hpp"
#include "world/devices/device_group.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::world {
namespace {

namespace fs = std::filesystem;

class ReadScene final : public api::NextScene {
 public:
  ReadScene(scene::Scene scene, ArmModels models, std::string text)
      : scene_(std::make_shared<const scene::Scene>(std::move(scene))),
        models_(std::move(models)),
        text_(std::move(text)) {}
  [[nodiscard]] const std::string& text() const override { return text_; }
  [[nodiscard]] const std::string& name() const override { return scene_->name; }
  [[nodiscard]] const std::shared_ptr<const scene::Scene>& scene() const { return scene_; }
  [[nodiscard]] const ArmModels& models() const { return models_; }

 private:
  std::shared_ptr<const scene::Scene> scene_;
  ArmModels models_;
  std::string text_;
};

}  // namespace

Result<std::shared_ptr<const api::NextScene>> read_next_scene(const api::Reset& reset,
                                                              const scene::Scene& present) {
  const scene::DataPaths paths = scene::default_data_paths();
  if (reset.scene_name.find('/') != std::string::npos || reset.scene_name.ends_with(".yaml") ||
      reset.scene_name.ends_with(".yml")) {
    return fail(ErrorCode::kInvalidArgument, "scene",
                "'" + reset.scene_name +
                    "' is a file's path; give the name of a scene that comes "
                    "with the daemon, or the text of one");
  }
  // Relative files of a text are those beside the scene that the daemon was started with.
  const std::string file = (fs::path(present.file).parent_path() / "sent.yaml").string();
  auto scene = reset.scene_name.empty()
                   ? scene::read_sent(reset.scene_text, file, paths, scene::files_of(present))
                   : scene::load_scene(reset.scene_name, paths);
  if (!scene) return tl::unexpected(std::move(scene.error()));
  const std::string source = reset.scene_name.empty() ? "scene text" : scene->name;
  if (scene->physics.step_s != present.physics.step_s) {
    return fail(ErrorCode::kFailedPrecondition, "scene",
                "scene " + scene->name + " has a step of " + std::to_string(scene->physics.step_s) +
                    " s, this cell " + std::to_string(present.physics.step_s) +
                    " s, which cannot change while it runs");
  }
  if (auto ok = devices::check_devices(*scene, source); !ok) return tl::unexpected(ok.error());
  // Model files by name alone, so that the text can be read on other machines.
  auto text = scene::portable_text(scene->text, scene->file);
  if (!text) return tl::unexpected(std::move(text.error()));
  try {
    ArmModels models = load_models(*scene);
    return std::make_shared<const ReadScene>(*std::move(scene), std::move(models),
                                             *std::move(text));
  } catch (const std::exception& failure) {
    return fail(ErrorCode::kFailedPrecondition, "scene", "scene " + source + ": " + failure.what());
  }
}

Result<void> add_next_scene(api::Command& command, const scene::Scene& present) {
  auto* simulation = std::get_if<api::SimulationCommand>(&command.body);
  auto* reset = simulation != nullptr ? std::get_if<api::Reset>(simulation) : nullptr;
  if (reset == nullptr || (reset->scene_name.empty() && reset->scene_text.empty())) return {};
  auto next = read_next_scene(*reset, present);
  if (!next) return tl::unexpected(std::move(next.error()));
  reset->next = *std::move(next);
  return {};
}

std::shared_ptr<const scene::Scene> scene_of(const api::NextScene& next) {
  return dynamic_cast<const ReadScene&>(next).scene();
}

const ArmModels& models_of(const api::NextScene& next) {
  return dynamic_cast<const ReadScene&>(next).models();
}

}  // namespace aprsim::world
