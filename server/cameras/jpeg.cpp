#include "server/cameras/jpeg.hpp"

#include <turbojpeg.h>

namespace aprsim::server {

JpegEncoder::JpegEncoder() : handle_(tjInitCompress()) {}

JpegEncoder::~JpegEncoder() {
  if (handle_ != nullptr) tjDestroy(handle_);
}

Result<std::string> JpegEncoder::encode(const render::Picture<std::uint8_t>& rgb, int quality) {
  if (handle_ == nullptr) return fail(ErrorCode::kUnavailable, "jpeg", "no memory for the encoder");
  std::string out(tjBufSize(rgb.width, rgb.height, TJSAMP_420), '\0');
  auto* buffer = reinterpret_cast<unsigned char*>(out.data());
  unsigned long size = out.size();
  if (tjCompress2(handle_, rgb.values.data(), rgb.width, 0, rgb.height, TJPF_RGB, &buffer, &size,
                  TJSAMP_420, quality, TJFLAG_NOREALLOC) != 0) {
    return fail(ErrorCode::kUnavailable, "jpeg", tjGetErrorStr2(handle_));
  }
  out.resize(size);
  out.shrink_to_fit();
  return out;
}

}  // namespace aprsim::server
