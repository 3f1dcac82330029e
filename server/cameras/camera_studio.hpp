#pragma once

#include <memory>

#include "protocols/ports/camera_pictures.hpp"
#include "world/api/ports/ports.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server {

/// Renders the pictures of a scene's cameras from snapshots, on one thread with a lower priority
/// than all others. It takes the latest snapshot for each picture; requests that wait for the same
/// camera share one. While nothing moves, the last picture is given again. The renderer of
/// a camera that nobody has asked for a minute is freed.
class CameraStudio final : public protocols::CameraPictures {
 public:
  /// The source outlives it. `seed`: of the noise.
  CameraStudio(std::shared_ptr<const scene::Scene> scene, const api::SnapshotSource& source,
               std::uint64_t seed);
  ~CameraStudio() override;
  CameraStudio(const CameraStudio&) = delete;
  CameraStudio& operator=(const CameraStudio&) = delete;

  [[nodiscard]] const std::vector<protocols::CameraInfo>& cameras() const override;
  void take_picture(std::size_t camera, protocols::PictureForm form, Done done) override;
  /// Answers what waits with an error, and every later request. Thread: the owner's.
  void stop();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::server
