#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "server/cameras/jpeg.hpp"
#include "server/replay/motion_options.hpp"
#include "server/replay/sample_times.hpp"
#include "world/base/files/draft_file.hpp"
#include "world/cell/world.hpp"
#include "world/render/cell/cell_model.hpp"
#include "world/render/renderer.hpp"
#include "world/runtime/record/recorder.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server {

/// Place in the scene of the camera with this name. Error: kNotFound,
/// field "camera", with the cameras there are.
[[nodiscard]] Result<std::size_t> camera_named(const scene::Scene& scene, const std::string& name);

/// Renders a camera's pictures during a replay and writes them as JPEG, one after another. A
/// picture is the one that the camera showed at this step, without its latency. While there is
/// none, as after its outage or in a scene without this camera, the last one is repeated. Thread:
/// the replay's.
class VideoFile {
 public:
  /// `camera`: of the scene at the beginning. `seed`: of the cell, for the noise.
  VideoFile(const MotionOptions& options, const scene::Camera& camera, std::uint64_t seed);

  /// Draws the world at the requested rate; call it after every step. False after a failure.
  [[nodiscard]] bool sample(const world::World& world, world::RunTime time);
  /// Writes the rest and moves the file into its place. Errors: the first failure of a picture;
  /// kUnavailable with the file; kFailedPrecondition when there is no picture.
  [[nodiscard]] Result<void> finish();

 private:
  Result<void> draw(const world::World& world);
  Result<void> prepare(const world::World& world);
  Result<void> take_picture(const scene::Camera& camera, const api::Snapshot& snapshot);

  SampleTimes times_;
  const std::string name_;
  const int width_px_, height_px_;
  const std::uint64_t seed_;
  files::DraftFile file_;
  JpegEncoder jpeg_;
  std::shared_ptr<const api::CellDescription> cell_;  ///< of the model
  std::optional<render::CellModel> model_;
  std::optional<scene::Camera> camera_;  ///< of the present scene; absent = it has none like it
  std::optional<render::Renderer> renderer_;
  std::string last_;  ///< picture
  std::uint64_t pictures_ = 0;
  std::optional<Error> failure_;
};

}  // namespace aprsim::server
