#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "world/base/result.hpp"
#include "world/base/time.hpp"

namespace aprsim::protocols {

/// Content and bytes of a picture.
enum class PictureForm {
  kJpeg,      ///< colours, in the camera's quality
  kRgb,       ///< a byte each of red, green and blue a pixel, sRGB
  kDepth,     ///< distance along the view as a float [m], 0 = nothing
  kSegments,  ///< number of the object as a 16-bit integer, 0 = nothing
  kNormals,   ///< unit normal in the world as three floats
};

/// A picture of one instant. Numbers are little-endian, rows run from the top, without gaps.
struct CameraPicture {
  std::uint64_t epoch = 0, step = 0;
  SimTime time{};
  int width = 0, height = 0;
  std::shared_ptr<const std::string> bytes;
};

struct CameraInfo {
  std::string name;
  int width = 0, height = 0;
  double rate_hz = 0;
  double latency_s = 0;
};

/// The cameras of a cell, numbered as in its scene. Nothing is rendered that nobody asked for.
class CameraPictures {
 public:
  using Done = std::function<void(Result<CameraPicture>)>;

  virtual ~CameraPictures() = default;
  /// The same ones as long as the daemon runs. Thread: any.
  [[nodiscard]] virtual const std::vector<CameraInfo>& cameras() const = 0;
  /// Takes a picture of the latest state. Calls `done` once, on a thread of its own, which `done`
  /// must not block. Errors: kUnavailable (the daemon is stopping, or the cell cannot be rendered).
  /// Thread: any; never blocks.
  virtual void take_picture(std::size_t camera, PictureForm form, Done done) = 0;
};

}  // namespace aprsim::protocols
