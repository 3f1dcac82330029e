#include "server/drafts/draft_builder.hpp"

#include <exception>
#include <filesystem>
#include <utility>
#include <vector>

#include "server/drafts/tray_reach.hpp"
#include "world/base/yaml/yaml_tree.hpp"
#include "world/cell/world.hpp"
#include "world/devices/device_group.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::server {
namespace {

constexpr std::size_t kMaxRobots = 16;  // of a draft; each reads a model

}  // namespace

DraftBuilder::DraftBuilder(std::shared_ptr<const scene::Scene> scene)
    : scene_(std::move(scene)), sources_(scene_) {}

web::SceneSource DraftBuilder::source_of(const api::CellDescription& cell) {
  const std::lock_guard lock(mutex_);
  return sources_.find(cell);
}

void DraftBuilder::build(std::string text, std::string name, Answer answer) {
  thread_.add({.run =
                   [this, request = Request{std::move(text), std::move(name)}, answer] {
                     Result<web::SceneDraft> made =
                         fail(ErrorCode::kUnavailable, "draft", "the draft could not be built");
                     try {
                       made = make(request);
                     } catch (const std::exception& failure) {
                       made = fail(ErrorCode::kInvalidArgument, "scene", failure.what());
                     }
                     answer(std::move(made));
                   },
               .refuse = [answer](const Error& error) { answer(tl::unexpected(error)); }});
}

Result<web::SceneDraft> DraftBuilder::make(const Request& request) {
  const std::string file =
      (std::filesystem::path(scene_->file).parent_path() / (request.name + ".yaml")).string();
  auto read =
      scene::read_sent(request.text, file, scene::default_data_paths(), scene::files_of(*scene_));
  if (!read) return tl::unexpected(std::move(read.error()));
  if (read->robots.size() > kMaxRobots) {
    return fail(ErrorCode::kInvalidArgument, "robots",
                "robots: found " + std::to_string(read->robots.size()) + ", expected at most " +
                    std::to_string(kMaxRobots) + " in a draft");
  }
  if (auto ok = devices::check_devices(*read, "scene text"); !ok) return tl::unexpected(ok.error());
  read->devices.clear();
  web::SceneDraft draft;
  for (const auto& robot : read->robots) {
    auto text = yaml::read_text(robot.model_file);
    if (!text) return tl::unexpected(std::move(text.error()));
    draft.models.push_back({robot.name, robot.model_file, *std::move(text)});
  }
  const auto scene = std::make_shared<const scene::Scene>(*std::move(read));
  const world::World world(scene, scene->seed);
  auto snapshot = std::make_shared<api::Snapshot>();
  world.write(*snapshot);
  snapshot->paused = true;
  draft.reaches = tray_reaches(world.models(), *snapshot);
  draft.snapshot = std::move(snapshot);
  const std::lock_guard lock(mutex_);
  sources_.keep(scene->text, request.text);
  return draft;
}

}  // namespace aprsim::server
