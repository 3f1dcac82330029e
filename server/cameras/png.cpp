#include "server/cameras/png.hpp"

#include <png.h>

namespace aprsim::server {

Result<std::string> png_of(const render::Picture<std::uint8_t>& rgb) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(rgb.width);
  image.height = static_cast<png_uint_32>(rgb.height);
  image.format = PNG_FORMAT_RGB;
  image.flags = PNG_IMAGE_FLAG_FAST;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string out(size, '\0');
  if (png_image_write_to_memory(&image, out.data(), &size, 0, rgb.values.data(), 0, nullptr) == 0) {
    return fail(ErrorCode::kUnavailable, "png", image.message);
  }
  out.resize(size);
  out.shrink_to_fit();
  return out;
}

}  // namespace aprsim::server
