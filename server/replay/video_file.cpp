#include "server/replay/video_file.hpp"

#include <exception>
#include <string>
#include <utility>

#include "world/base/time.hpp"
#include "world/render/camera_faults.hpp"

namespace aprsim::server {
namespace {

constexpr int kVideoQuality = 95;  // the video is compressed once more

}  // namespace

Result<std::size_t> camera_named(const scene::Scene& scene, const std::string& name) {
  std::string known;
  for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
    if (scene.cameras[i].name == name) return i;
    known += (known.empty() ? "" : ", ") + scene.cameras[i].name;
  }
  return fail(ErrorCode::kNotFound, "camera",
              "the recorded scene has no camera '" + name + "'; there is " +
                  (known.empty() ? "none" : known));
}

VideoFile::VideoFile(const MotionOptions& options, const scene::Camera& camera, std::uint64_t seed)
    : times_(options),
      name_(camera.name),
      width_px_(camera.lens.width_px),
      height_px_(camera.lens.height_px),
      seed_(seed),
      file_(options.video) {}

bool VideoFile::sample(const world::World& world, world::RunTime time) {
  if (failure_ || !times_.is_due(world, time)) return !failure_;
  try {
    if (auto drawn = draw(world); !drawn) failure_ = drawn.error();
  } catch (const std::exception& problem) {
    failure_ = Error{ErrorCode::kUnavailable, "video",
                     std::string("the cell cannot be rendered: ") + problem.what()};
  }
  return !failure_;
}

Result<void> VideoFile::draw(const world::World& world) {
  if (auto ready = prepare(world); !ready) return ready;
  api::Snapshot snapshot;
  world.write(snapshot);
  if (camera_) {
    if (const auto camera = render::with_faults(*camera_, snapshot.faults.get())) {
      if (auto taken = take_picture(*camera, snapshot); !taken) return taken;
    }
  }
  if (last_.empty()) return {};
  file_.out() << last_;
  ++pictures_;
  return {};
}

Result<void> VideoFile::take_picture(const scene::Camera& camera, const api::Snapshot& snapshot) {
  const auto& placements = model_->place(snapshot);
  renderer_->set_camera(camera, model_->X_WC(camera).isometry(), seconds(snapshot.time));
  if (auto drawn = renderer_->draw(placements, snapshot.step); !drawn) {
    return tl::unexpected(drawn.error());
  }
  auto picture = jpeg_.encode(renderer_->rgb(), kVideoQuality);
  if (!picture) return tl::unexpected(picture.error());
  last_ = *std::move(picture);
  return {};
}

Result<void> VideoFile::prepare(const world::World& world) {
  if (model_ && cell_ == world.description()) return {};
  auto model = render::CellModel::make(*world.scene(), *world.description());
  if (!model) return tl::unexpected(model.error());
  // Its placements refer to the meshes of the model.
  renderer_.reset();
  camera_.reset();
  model_.emplace(*std::move(model));
  cell_ = world.description();
  const auto place = camera_named(*world.scene(), name_);
  if (!place) return {};
  const scene::Camera& camera = world.scene()->cameras[*place];
  if (camera.lens.width_px != width_px_ || camera.lens.height_px != height_px_) return {};
  camera_ = camera;
  renderer_.emplace(camera, render::lamps_over(model_->extent()), seed_ + *place, model_->extent());
  return {};
}

Result<void> VideoFile::finish() {
  if (failure_) return tl::unexpected(*failure_);
  if (pictures_ == 0) {
    return fail(ErrorCode::kFailedPrecondition, "video", "the chosen time has no picture");
  }
  return file_.commit();
}

}  // namespace aprsim::server
