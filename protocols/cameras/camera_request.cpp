#include "protocols/cameras/camera_request.hpp"

#include <algorithm>

namespace aprsim::camera_server {
namespace {

constexpr std::string_view kSecurity =
    "Cache-Control: no-cache\r\nPragma: no-cache\r\nX-Content-Type-Options: nosniff\r\n";

std::string answer(std::string_view status, std::string_view extra, std::string_view text) {
  std::string out = "HTTP/1.1 ";
  out += status;
  out += "\r\nConnection: close\r\nContent-Type: text/plain; charset=utf-8\r\n";
  out += kSecurity;
  out += extra;
  out += "Content-Length: " + std::to_string(text.size()) + "\r\n\r\n";
  out += text;
  return out;
}

}  // namespace

CameraRequest read_request(std::string_view head) {
  using Kind = CameraRequest::Kind;
  CameraRequest request;
  const std::string_view line = head.substr(0, head.find("\r\n"));
  const std::size_t first = line.find(' '), last = line.rfind(' ');
  if (first == std::string_view::npos || last <= first + 1 ||
      !line.substr(last + 1).starts_with("HTTP/1.")) {
    return request;
  }
  const std::string_view method = line.substr(0, first);
  std::string_view path = line.substr(first + 1, last - first - 1);
  path = path.substr(0, path.find('?'));
  request.head = method == "HEAD";
  if (method != "GET" && method != "HEAD") {
    request.kind = Kind::kBadMethod;
  } else if (path == "/mjpg/video.mjpg" || path == "/axis-cgi/mjpg/video.cgi") {
    request.kind = Kind::kVideo;
  } else if (path == "/jpg/image.jpg" || path == "/axis-cgi/jpg/image.cgi") {
    request.kind = Kind::kImage;
  } else {
    request.kind = Kind::kNotFound;
  }
  return request;
}

std::string video_head() {
  std::string out = "HTTP/1.1 200 OK\r\nConnection: close\r\n";
  out += kSecurity;
  out += "Content-Type: multipart/x-mixed-replace; boundary=";
  out += kBoundary;
  out += "\r\n\r\n";
  return out;
}

std::string part_head(std::size_t bytes) {
  std::string out = "--";
  out += kBoundary;
  out += "\r\nContent-Type: image/jpeg\r\nContent-Length: " + std::to_string(bytes) + "\r\n\r\n";
  return out;
}

std::string image_head(std::size_t bytes) {
  std::string out = "HTTP/1.1 200 OK\r\nConnection: close\r\n";
  out += kSecurity;
  out += "Content-Type: image/jpeg\r\nContent-Length: " + std::to_string(bytes) + "\r\n\r\n";
  return out;
}

std::string refusal(CameraRequest::Kind kind) {
  using Kind = CameraRequest::Kind;
  switch (kind) {
    case Kind::kNotFound:
      return answer("404 Not Found", "",
                    "This camera has /mjpg/video.mjpg and /jpg/image.jpg only.\n");
    case Kind::kBadMethod:
      return answer("405 Method Not Allowed", "Allow: GET, HEAD\r\n",
                    "Only GET and HEAD are supported.\n");
    default:
      return answer("400 Bad Request", "", "This is not a request of HTTP/1.1.\n");
  }
}

}  // namespace aprsim::camera_server
