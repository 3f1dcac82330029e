#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "world/api/description/cell_description.hpp"
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
  Pose X_WC;  ///< camera frame in world
  // For streams: camera and faults at this instant.
  double rate_hz = 10, latency_s = 0;
  std::shared_ptr<const std::string> bytes;
  std::shared_ptr<const std::vector<PictureObject>>
      objects;  ///< of the scene; the first is nothing
};

using CameraList = std::vector<api::CameraDescription>;

/// The cameras of a cell. Nothing is rendered that nobody asked for.
class CameraPictures {
 public:
  using Done = std::function<void(Result<CameraPicture>)>;

  virtual ~CameraPictures() = default;
  /// Those of the present scene, in its order; never null. Thread: any.
  [[nodiscard]] virtual std::shared_ptr<const CameraList> cameras() const = 0;
  /// Takes a picture of the latest state. Calls `done` once, on a thread of its own, which `done`
  /// must not block. Errors: kNotFound (the present scene has no such camera), kUnavailable (the
  /// camera is out of order, the daemon is stopping, or the cell cannot be rendered),
  /// kFailedPrecondition (too little memory). Thread: any; never blocks.
  virtual void take_picture(const std::string& camera, PictureForm form, Done done) = 0;
};

}  // namespace aprsim::protocols
