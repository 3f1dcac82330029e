#include "server/cameras/picture_encoder.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "server/cameras/png.hpp"

namespace aprsim::server {
namespace {

using protocols::PictureForm;

static_assert(std::endian::native == std::endian::little, "numbers are sent in this order");

template <typename T>
std::string bytes_of(const render::Picture<T>& picture) {
  std::string out(picture.values.size() * sizeof(T), '\0');
  std::memcpy(out.data(), picture.values.data(), out.size());
  return out;
}

/// Depths in tenths of millimetres.
render::Picture<std::uint16_t> rounded(const render::Picture<float>& depth) {
  static constexpr float kPerMetre = 1e4F, kMost = 65535;
  render::Picture<std::uint16_t> out(depth.width, depth.height, 1);
  std::ranges::transform(depth.values, out.values.begin(), [](float metres) {
    return static_cast<std::uint16_t>(std::min(std::round(metres * kPerMetre), kMost));
  });
  return out;
}

}  // namespace

Result<std::string> PictureEncoder::encode(const render::Renderer& renderer,
                                           const render::CellModel& model, PictureForm form,
                                           int jpeg_quality) {
  switch (form) {
    case PictureForm::kJpeg:
      return jpeg_.encode(renderer.rgb(), jpeg_quality);
    case PictureForm::kPng:
      return png_of(renderer.rgb());
    case PictureForm::kRgb:
      return bytes_of(renderer.rgb());
    case PictureForm::kDepth:
      return bytes_of(renderer.depth());
    case PictureForm::kDepth16:
      return bytes_of(rounded(renderer.depth()));
    case PictureForm::kSegments:
      return bytes_of(renderer.segments(model.object_of()));
    case PictureForm::kNormals:
      return bytes_of(renderer.normals());
  }
  return fail(ErrorCode::kUnavailable, "camera", "no such form");
}

std::uint64_t PictureEncoder::most_bytes(const scene::Lens& lens, PictureForm form) {
  const auto pixels =
      static_cast<std::uint64_t>(lens.width_px) * static_cast<std::uint64_t>(lens.height_px);
  // For each pixel: the values before they are bytes, and the bytes, which a file copies once.
  constexpr std::uint64_t kHead = 65536, kFile = 2 * 4;
  switch (form) {
    case PictureForm::kRgb:
      return 3 * pixels;
    case PictureForm::kDepth:
      return (4 + 4) * pixels;
    case PictureForm::kDepth16:
      return (4 + 2 + 2) * pixels;
    case PictureForm::kSegments:
      return (2 + 2) * pixels;
    case PictureForm::kNormals:
      return (12 + 12) * pixels;
    case PictureForm::kJpeg:
    case PictureForm::kPng:
      break;
  }
  return kFile * pixels + kHead;
}

}  // namespace aprsim::server
