#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "world/base/result.hpp"
#include "world/render/exposure.hpp"
#include "world/render/picture.hpp"
#include "world/render/raster/rasterizer.hpp"
#include "world/render/raster/shadow_map.hpp"
#include "world/render/shading.hpp"
#include "world/scene/model/camera.hpp"

namespace aprsim::render {

/// Lamps of a cell that extends over this box: one to each side, above everything.
[[nodiscard]] std::vector<Lamp> lamps_over(const Eigen::AlignedBox3d& extent);

/// The pictures of one camera. Only tiles over which something moved, or its shadow, are drawn
/// again. The pictures are the same bits for the same placements, camera, time, frame number and
/// seed, whatever was drawn before and with any number of threads. Thread: one at a time.
class Renderer {
 public:
  /// `cell`: box around what a camera that moves may see.
  Renderer(const scene::Camera& camera, const std::vector<Lamp>& lamps, std::uint64_t seed,
           const Eigen::AlignedBox3d& cell = {});
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  /// Memory of a renderer with two lamps before it has drawn anything.
  [[nodiscard]] static std::uint64_t fixed_bytes(const scene::Camera& camera);
  /// Memory at present.
  [[nodiscard]] std::uint64_t bytes() const { return budget_.used(); }
  void set_limit(std::uint64_t bytes) { budget_.set_limit(bytes); }

  /// Pose, dirt, flicker and noise from now on; `camera` has the same lens. `time_s`: simulated.
  /// Returns whether pictures become others.
  bool set_camera(const scene::Camera& camera, const Eigen::Isometry3d& X_WC, double time_s);
  /// Draws the placements, which keep their order and meshes. `frame`: number of its noise.
  /// Returns how many tiles were drawn. Error: kFailedPrecondition where the limit of memory would
  /// be exceeded; the renderer is of no use then.
  Result<std::size_t> draw(const std::vector<Placement>& placements, std::uint64_t frame,
                           int threads = 1);

  [[nodiscard]] const scene::Camera& camera() const { return camera_; }
  [[nodiscard]] std::size_t tiles() const { return grid().tiles(); }
  // Results of the last draw().
  [[nodiscard]] const Picture<std::uint8_t>& rgb() const { return rgb_; }
  /// Distance along the view [m], 0 = nothing there.
  [[nodiscard]] Picture<float> depth() const;
  /// The value of each pixel's placement in `object_of`; 0 where there is none.
  [[nodiscard]] Picture<std::uint16_t> segments(const std::vector<std::uint16_t>& object_of) const;
  /// Unit normals in the world; 0 where there is nothing.
  [[nodiscard]] Picture<float> normals() const;

 private:
  [[nodiscard]] const TileGrid& grid() const { return raster_.rays().grid; }
  [[nodiscard]] View view() const;
  /// The first pixel of a tile.
  [[nodiscard]] std::pair<int, int> corner_of(std::size_t tile) const;
  void shade_tile(std::size_t tile);
  [[nodiscard]] TileSet tiles_to_shade(const TileSet& drawn) const;
  void expose(const TileSet& shaded, std::uint64_t frame, int threads);
  [[nodiscard]] bool remember(const std::vector<Placement>& placements);

  scene::Camera camera_;
  MemoryBudget budget_;
  Eigen::Isometry3d X_WC_, X_CW_;
  Rasterizer raster_;
  std::vector<ShadowMap> shadows_;
  std::vector<ShadowMap::Range> lit_from_;  // of each tile, one a lamp
  std::vector<Placement> placements_;
  std::vector<Eigen::Matrix3f> R_WP_;  // of the placements
  Eigen::Matrix3f R_WC_;
  Eigen::Vector3f eye_W_;
  Picture<float> light_;
  Exposure exposure_;
  Picture<std::uint8_t> rgb_;
  std::uint64_t frame_ = 0;
  bool exposed_ = false, all_due_ = false;
};

}  // namespace aprsim::render
