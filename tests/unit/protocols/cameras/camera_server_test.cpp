#include "protocols/cameras/camera_server.hpp"

#include <atomic>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/eventually.hpp"
#include "tests/support/numbered_pictures.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/tcp_socket.hpp"

namespace aprsim::camera_server {
namespace {

using namespace std::chrono_literals;
using test::eventually;
using test::TcpSocket;

class CameraServerTest : public testing::Test {
 protected:
  std::uint16_t start(double rate_hz, std::size_t bytes = 20) {
    pictures.emplace(
        protocols::CameraList{{.name = "table", .width_px = 4, .height_px = 4, .rate_hz = rate_hz}},
        bytes);
    options.camera = "table";
    options.listener.port = 0;
    server.emplace(options, *pictures);
    return server->start().value();
  }
  /// Receives until the text has come, and returns all.
  static std::string receive_until(TcpSocket& client, const std::string& text) {
    const auto deadline = TcpSocket::Clock::now() + 10s * test::kPatience;
    std::string all;
    while (all.find(text) == std::string::npos) {
      const std::string more = client.receive(deadline);
      if (more.empty()) break;
      all += more;
    }
    return all;
  }

  CameraServerOptions options;
  std::optional<test::NumberedPictures> pictures;
  std::optional<CameraServer> server;
};

TEST_F(CameraServerTest, AStreamHasEachPictureAsAPart) {
  TcpSocket client(start(200));
  ASSERT_TRUE(client.send("GET /mjpg/video.mjpg HTTP/1.1\r\nHost: camera\r\n\r\n"));
  const std::string all = receive_until(client, "picture 3 ");
  EXPECT_TRUE(all.starts_with("HTTP/1.1 200 OK\r\n"));
  EXPECT_NE(all.find("boundary=myboundary\r\n"), std::string::npos);
  EXPECT_NE(
      all.find("\r\n\r\n--myboundary\r\nContent-Type: image/jpeg\r\nContent-Length: 20\r\n\r\n"
               "picture 1 ..........\r\n--myboundary\r\n"),
      std::string::npos);
}

TEST_F(CameraServerTest, OnePictureEndsItsConnection) {
  TcpSocket client(start(200));
  ASSERT_TRUE(client.send("GET /jpg/image.jpg HTTP/1.1\r\n\r\n"));
  const std::string all = receive_until(client, "never");
  EXPECT_TRUE(all.starts_with("HTTP/1.1 200 OK\r\n"));
  EXPECT_NE(all.find("Content-Type: image/jpeg\r\nContent-Length: 20\r\n\r\npicture 1"),
            std::string::npos);
}

TEST_F(CameraServerTest, WithoutClientsNoPictureIsTaken) {
  const std::uint16_t port = start(200);
  {
    TcpSocket client(port);
    ASSERT_TRUE(client.send("GET /mjpg/video.mjpg HTTP/1.1\r\n\r\n"));
    receive_until(client, "picture 2 ");
  }
  ASSERT_TRUE(eventually([&] { return server->stats().open == 0; }));
  const std::uint64_t taken = pictures->taken;
  // Another client gets the very next one, whenever it comes: at most one was under way.
  TcpSocket client(port);
  ASSERT_TRUE(client.send("GET /jpg/image.jpg HTTP/1.1\r\n\r\n"));
  const std::string all = receive_until(client, "picture ");
  EXPECT_TRUE(all.find("picture " + std::to_string(taken + 1) + ' ') != std::string::npos ||
              all.find("picture " + std::to_string(taken + 2) + ' ') != std::string::npos);
}

TEST_F(CameraServerTest, ASlowReaderMissesPicturesAndTheOthersDoNot) {
  const std::uint16_t port = start(500, 400'000);
  TcpSocket slow(port, 4096), quick(port);
  for (TcpSocket* client : {&slow, &quick}) {
    ASSERT_TRUE(client->send("GET /mjpg/video.mjpg HTTP/1.1\r\n\r\n"));
  }
  receive_until(quick, "picture 12 ");
  EXPECT_TRUE(eventually([&] { return server->stats().skipped > 3; }));
  EXPECT_EQ(server->stats().open, 2U);
}

TEST_F(CameraServerTest, AReaderThatTakesNothingIsDropped) {
  options.timeout = 100ms;
  TcpSocket client(start(200, 4'000'000), 4096);
  ASSERT_TRUE(client.send("GET /mjpg/video.mjpg HTTP/1.1\r\n\r\n"));
  EXPECT_TRUE(eventually([&] { return server->stats().dropped == 1; }));
}

TEST_F(CameraServerTest, AClientThatAsksForNothingIsDropped) {
  options.timeout = 100ms;
  TcpSocket silent(start(200));
  EXPECT_TRUE(silent.ended());
  EXPECT_EQ(server->stats().dropped, 1U);
}

TEST_F(CameraServerTest, ARequestWithoutAnEndIsDropped) {
  TcpSocket chatty(start(200));
  const std::string line(1024, 'x');
  while (server->stats().dropped == 0 && chatty.send(line)) {
  }
  EXPECT_TRUE(eventually([&] { return server->stats().dropped == 1; }));
}

TEST_F(CameraServerTest, OtherPathsAreRefusedInPlainWords) {
  TcpSocket client(start(200));
  ASSERT_TRUE(client.send("GET /index.html HTTP/1.1\r\n\r\n"));
  const std::string all = receive_until(client, "never");
  EXPECT_TRUE(all.starts_with("HTTP/1.1 404 Not Found\r\n"));
  EXPECT_NE(all.find("/mjpg/video.mjpg"), std::string::npos);
  EXPECT_EQ(pictures->taken, 0U);
}

TEST_F(CameraServerTest, AStreamGoesOnAfterAPictureThatCouldNotBeTaken) {
  const std::uint16_t port = start(200);
  pictures->fails = true;
  TcpSocket client(port);
  ASSERT_TRUE(client.send("GET /mjpg/video.mjpg HTTP/1.1\r\n\r\n"));
  ASSERT_TRUE(eventually([&] { return pictures->taken > 2; }));
  pictures->fails = false;
  EXPECT_NE(receive_until(client, "picture ").find("picture "), std::string::npos);
}

TEST_F(CameraServerTest, ADelayOfThePicturesKeepsTheirOrder) {
  const std::uint16_t port = start(100);
  pictures->latency_s = 0.3;
  TcpSocket client(port);
  const auto begin = TcpSocket::Clock::now();
  ASSERT_TRUE(client.send("GET /mjpg/video.mjpg HTTP/1.1\r\n\r\n"));
  receive_until(client, "picture 1 ");
  EXPECT_GE(TcpSocket::Clock::now() - begin, 300ms);
  // The delay ends: what was taken before still comes first. Those that are due at once may be
  // lost.
  pictures->latency_s = 0;
  const auto deadline = TcpSocket::Clock::now() + 10s * test::kPatience;
  std::size_t last = 1;
  for (std::string all; last < 60 && TcpSocket::Clock::now() < deadline;) {
    all += client.receive(deadline);
    for (std::size_t at = 0; (at = all.find("picture ")) != std::string::npos;) {
      const std::size_t end = all.find('.', at);
      if (end == std::string::npos) break;
      const std::size_t number = std::stoul(all.substr(at + 8));
      EXPECT_GT(number, last);
      last = number;
      all.erase(0, end);
    }
  }
  EXPECT_GE(last, 60U);
}

TEST_F(CameraServerTest, ASlowCameraTakesFewerPictures) {
  const std::uint16_t port = start(200);
  pictures->rate_hz = 5;
  TcpSocket client(port);
  ASSERT_TRUE(client.send("GET /mjpg/video.mjpg HTTP/1.1\r\n\r\n"));
  receive_until(client, "picture 1 ");
  const auto begin = TcpSocket::Clock::now();
  receive_until(client, "picture 3 ");
  EXPECT_GE(TcpSocket::Clock::now() - begin, 300ms);
}

TEST_F(CameraServerTest, StoppingClosesStreams) {
  TcpSocket client(start(200));
  ASSERT_TRUE(client.send("GET /mjpg/video.mjpg HTTP/1.1\r\n\r\n"));
  receive_until(client, "picture 1 ");
  server->stop();
  EXPECT_TRUE(client.ended());
}

}  // namespace
}  // namespace aprsim::camera_server
