#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "world/api/snapshot/snapshot.hpp"
#include "world/scene/model/scene.hpp"

namespace aprsim::bench {

/// MuJoCo's renderer on Mesa's software OpenGL, in the calling thread, with one lamp that casts
/// shadows. It shows fixed boxes, belt, trays as boxes and gears as two cylinders, without arms.
class MujocoPictures {
 public:
  /// Looks as the scene's first camera does, without distortion. Throws std::runtime_error.
  MujocoPictures(const scene::Scene& scene, const api::Snapshot& snapshot, int width, int height);
  ~MujocoPictures();
  MujocoPictures(const MujocoPictures&) = delete;
  MujocoPictures& operator=(const MujocoPictures&) = delete;

  /// Draws colours and depth, and reads them back. Returns the mean of the colours.
  double draw();
  [[nodiscard]] static std::string version();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace aprsim::bench
