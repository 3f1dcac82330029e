#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "world/api/values/pose.hpp"
#include "world/base/result.hpp"
#include "world/base/time.hpp"

namespace aprsim::protocols {

/// Content and bytes of a picture.
enum class PictureForm {
  kJpeg,      ///< colours, in the camera's quality
  kPng,       ///< colours
  kRgb,       ///< a byte each of red, green and blue a pixel, sRGB
  kDepth,     ///< distance along the view as a float [m], 0 = nothing
  kDepth16,   ///< the same as a 16-bit integer [0.1 mm], at most 65535
  kSegments,  ///< number of the object as a 16-bit integer, 0 = nothing
  kNormals,   ///< unit normal in the world as three floats
};

/// One thing that a segmented picture tells apart. Its number is its place in the list.
struct PictureObject {
  enum class Kind { kNothing, kBody, kRobot, kTool, kFixed, kBelt, kFloor, kIntruder };
  Kind kind = Kind::kNothing;
  std::string name;
};

/// A picture of one instant. Numbers are little-endian, rows run from the top, without gaps.
struct CameraPicture {
  std::uint64_t epoch = 0, step = 0;
  SimTime time{};
  int width = 0, height = 0;
  std::shared_ptr<const std::string> bytes;
  std::shared_ptr<const std::vector<PictureObject>>
      objects;  ///< of the scene; the first is nothing
};

struct CameraInfo {
  std::string name;
  std::string robot;  ///< that it serves; empty = none
  int width = 0, height = 0;
  double rate_hz = 0;
  double latency_s = 0;
  // The camera frame has x to the right of the picture, y down, z along the view.
  Pose X_WC;
  std::array<double, 2> focal_px{}, centre_px{};
  std::array<double, 5> distortion{};  ///< by Brown: k1, k2, p1, p2, k3
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
