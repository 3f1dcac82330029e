#include "protocols/cameras/camera_request.hpp"

#include <gtest/gtest.h>

namespace aprsim::camera_server {
namespace {

using Kind = CameraRequest::Kind;

Kind kind_of(std::string_view head) { return read_request(head).kind; }

TEST(CameraRequest, KnowsThePathsOfAxisCameras) {
  EXPECT_EQ(kind_of("GET /mjpg/video.mjpg HTTP/1.1\r\nHost: x\r\n\r\n"), Kind::kVideo);
  EXPECT_EQ(kind_of("GET /mjpg/video.mjpg?resolution=640x480 HTTP/1.0\r\n\r\n"), Kind::kVideo);
  EXPECT_EQ(kind_of("GET /axis-cgi/mjpg/video.cgi HTTP/1.1\r\n\r\n"), Kind::kVideo);
  EXPECT_EQ(kind_of("GET /jpg/image.jpg HTTP/1.1\r\n\r\n"), Kind::kImage);
  EXPECT_EQ(kind_of("GET /axis-cgi/jpg/image.cgi?x=1 HTTP/1.1\r\n\r\n"), Kind::kImage);
  EXPECT_TRUE(read_request("HEAD /jpg/image.jpg HTTP/1.1\r\n\r\n").head);
}

TEST(CameraRequest, RefusesAllElse) {
  EXPECT_EQ(kind_of("GET / HTTP/1.1\r\n\r\n"), Kind::kNotFound);
  EXPECT_EQ(kind_of("GET /jpg/image.jpg/.. HTTP/1.1\r\n\r\n"), Kind::kNotFound);
  EXPECT_EQ(kind_of("POST /jpg/image.jpg HTTP/1.1\r\n\r\n"), Kind::kBadMethod);
  EXPECT_EQ(kind_of("GET /jpg/image.jpg\r\n\r\n"), Kind::kMalformed);
  EXPECT_EQ(kind_of("GET  HTTP/1.1\r\n\r\n"), Kind::kMalformed);
  EXPECT_EQ(kind_of(std::string_view("\0\xff\r\n\r\n", 6)), Kind::kMalformed);
  EXPECT_EQ(kind_of("\r\n\r\n"), Kind::kMalformed);
}

TEST(CameraRequest, AnswersHaveTheHeadersOfAxisCameras) {
  EXPECT_NE(video_head().find("Content-Type: multipart/x-mixed-replace; boundary=myboundary\r\n"),
            std::string::npos);
  EXPECT_EQ(part_head(12),
            "--myboundary\r\nContent-Type: image/jpeg\r\nContent-Length: 12\r\n\r\n");
  EXPECT_NE(refusal(Kind::kBadMethod).find("Allow: GET, HEAD\r\n"), std::string::npos);
}

}  // namespace
}  // namespace aprsim::camera_server
