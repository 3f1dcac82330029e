#pragma once

#include <string>

#include "protocols/ports/camera_pictures.hpp"
#include "server/cameras/jpeg.hpp"
#include "world/render/cell/cell_model.hpp"
#include "world/render/renderer.hpp"

namespace aprsim::server {

/// The bytes of a renderer's picture in any form. Thread: one at a time.
class PictureEncoder {
 public:
  /// `jpeg_quality`: 1 to 100. Error: kUnavailable.
  [[nodiscard]] Result<std::string> encode(const render::Renderer& renderer,
                                           const render::CellModel& model,
                                           protocols::PictureForm form, int jpeg_quality);
  /// Memory that encoding takes at most, with its result.
  [[nodiscard]] static std::uint64_t most_bytes(const scene::Lens& lens,
                                                protocols::PictureForm form);

 private:
  JpegEncoder jpeg_;
};

}  // namespace aprsim::server
