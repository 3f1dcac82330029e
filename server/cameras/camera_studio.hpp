#pragma once

#include <cstdint>
#include <memory>

#include "protocols/ports/camera_pictures.hpp"
#include "world/api/ports/ports.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::server {

struct StudioOptions {
  std::uint64_t seed = 0;                               ///< of the noise
  std::uint64_t max_bytes = std::uint64_t{256} << 20U;  ///< limit of all its memory
};

/// Renders the pictures of the present scene's cameras from snapshots, on one thread with a lower
/// priority than all others. It takes the latest snapshot for each picture; requests that wait for
/// the same camera share one. While nothing moves, the last picture is given again. The renderer of
/// a camera that nobody has asked for a minute is freed, or earlier where another camera needs its
/// memory. Pictures beyond the limit of memory are refused.
class CameraStudio final : public protocols::CameraPictures {
 public:
  /// `scene`: the cell's at the start. The source outlives it.
  CameraStudio(std::shared_ptr<const scene::Scene> scene, const api::SnapshotSource& source,
               StudioOptions options);
  ~CameraStudio() override;
  CameraStudio(const CameraStudio&) = delete;
  CameraStudio& operator=(const CameraStudio&) = delete;

  [[nodiscard]] std::shared_ptr<const protocols::CameraList> cameras() const override;
  void take_picture(const std::string& camera, protocols::PictureForm form, Done done) override;
  /// Memory in use. Thread: any.
  [[nodiscard]] std::uint64_t bytes() const;
  /// Answers what waits with an error, and every later request. Thread: the owner's.
  void stop();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::server
