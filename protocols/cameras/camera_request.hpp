#pragma once

#include <string>
#include <string_view>

namespace aprsim::camera_server {

/// A request to a camera's HTTP server.
struct CameraRequest {
  enum class Kind { kVideo, kImage, kNotFound, kBadMethod, kMalformed };
  Kind kind = Kind::kMalformed;
  bool head = false;  ///< HEAD: no body is wanted
};

/// Longest head of a request.
inline constexpr std::size_t kMaxHead = 8 * 1024;

/// From the head of a request, up to its empty line. Paths are those of Axis cameras (VAPIX):
/// /mjpg/video.mjpg and /jpg/image.jpg, or /axis-cgi/mjpg/video.cgi and /axis-cgi/jpg/image.cgi.
/// Queries are ignored.
[[nodiscard]] CameraRequest read_request(std::string_view head);

inline constexpr std::string_view kBoundary = "myboundary";
/// Head of the answer with a stream of pictures.
[[nodiscard]] std::string video_head();
/// Head of one picture in a stream; the picture and an empty line follow.
[[nodiscard]] std::string part_head(std::size_t bytes);
/// Head of the answer with one picture.
[[nodiscard]] std::string image_head(std::size_t bytes);
/// The whole answer to a request that is refused.
[[nodiscard]] std::string refusal(CameraRequest::Kind kind);

}  // namespace aprsim::camera_server
