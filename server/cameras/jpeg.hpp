#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "world/base/result.hpp"
#include "world/render/picture.hpp"

namespace aprsim::server {

/// Compresses pictures as baseline JPEG with colours at half the resolution. Thread: one at a time.
class JpegEncoder {
 public:
  JpegEncoder();
  ~JpegEncoder();
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;

  /// `quality`: 1 to 100. Error: kUnavailable, with the library's message.
  [[nodiscard]] Result<std::string> encode(const render::Picture<std::uint8_t>& rgb, int quality);

 private:
  void* handle_;
};

}  // namespace aprsim::server
