#pragma once

#include <cstdint>
#include <memory>

#include "protocols/ports/camera_pictures.hpp"
#include "world/api/ports/ports.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server {

struct StudioOptions {
  std::uint64_t seed = 0;                               ///< of the noise
  std::uint64_t max_bytes = std::uint64_t{256} << 20U;  ///< limit of the renderers' memory
};

/// Renders the pictures of a scene's cameras from snapshots, on one thread with a lower priority
/// than all others. It takes the latest snapshot for each picture; requests that wait for the same
/// camera share one. While nothing moves, the last picture is given again. The renderer of
/// a camera that nobody has asked for a minute is freed, or earlier where another camera needs its
/// memory.
class CameraStudio final : public protocols::CameraPictures {
 public:
  /// The source outlives it.
  CameraStudio(std::shared_ptr<const scene::Scene> scene, const api::SnapshotSource& source,
               StudioOptions options);
  ~CameraStudio() override;
  CameraStudio(const CameraStudio&) = delete;
  CameraStudio& operator=(const CameraStudio&) = delete;

  [[nodiscard]] const std::vector<protocols::CameraInfo>& cameras() const override;
  void take_picture(std::size_t camera, protocols::PictureForm form, Done done) override;
  /// Memory of the renderers in use. Thread: any.
  [[nodiscard]] std::uint64_t bytes() const;
  /// Answers what waits with an error, and every later request. Thread: the owner's.
  void stop();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::server
