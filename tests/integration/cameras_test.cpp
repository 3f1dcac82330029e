// Pictures of the real daemon's cameras over HTTP.

#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/cell_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/patience.hpp"
#include "tests/support/tcp_socket.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

/// Pictures come from a thread of low priority.
constexpr std::chrono::milliseconds kLongest = 240s * kPatience;

/// Width and height in the frame header of a JPEG picture (ITU T.81, B.2.2); 0 = there is none.
std::pair<int, int> jpeg_size(const std::string& jpeg) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(jpeg.at(i)); };
  const auto word = [&](std::size_t i) { return byte(i) << 8 | byte(i + 1); };
  if (word(0) != 0xffd8 || word(jpeg.size() - 2) != 0xffd9) return {};
  for (std::size_t at = 2; byte(at) == 0xff; at += 2 + static_cast<std::size_t>(word(at + 2))) {
    if (byte(at + 1) == 0xc0) return {word(at + 7), word(at + 5)};
  }
  return {};
}

/// A reader of one camera's stream that shares no code with the server.
class StreamReader {
 public:
  explicit StreamReader(std::uint16_t port, int receive_buffer = 0)
      : socket_(port, receive_buffer) {
    if (!socket_.send("GET /mjpg/video.mjpg HTTP/1.1\r\nHost: camera\r\n\r\n")) {
      throw std::runtime_error("the camera takes no request");
    }
  }

  std::string head() { return read_until("\r\n\r\n"); }
  /// The next picture; after head().
  std::string picture() {
    const std::string part = read_until("\r\n\r\n");
    const std::string begin = "--myboundary\r\nContent-Type: image/jpeg\r\nContent-Length: ";
    EXPECT_TRUE(part.starts_with(begin)) << part.substr(0, 200);
    std::size_t size = 0;
    std::from_chars(part.data() + begin.size(), part.data() + part.size(), size);
    while (input_.size() < size + 2) fill();
    std::string out = input_.substr(0, size);
    EXPECT_EQ(input_.substr(size, 2), "\r\n");
    input_.erase(0, size + 2);
    return out;
  }

 private:
  void fill() {
    const std::string more = socket_.receive(TcpSocket::Clock::now() + kLongest);
    if (more.empty()) throw std::runtime_error("the camera has ended its stream");
    input_ += more;
  }
  std::string read_until(const std::string& end) {
    std::size_t at = 0;
    while ((at = input_.find(end)) == std::string::npos) fill();
    std::string out = input_.substr(0, at + end.size());
    input_.erase(0, out.size());
    return out;
  }

  TcpSocket socket_;
  std::string input_;
};

/// The whole answer of the page's port to one request.
std::string page_request(const DaemonProcess& daemon, const std::string& head,
                         const std::string& headers = "") {
  TcpSocket socket(daemon.port("web"));
  EXPECT_TRUE(
      socket.send(head + "\r\nHost: localhost\r\nConnection: close\r\n" + headers + "\r\n"));
  std::string answer;
  for (std::string more; !(more = socket.receive(TcpSocket::Clock::now() + kLongest)).empty();) {
    answer += more;
  }
  return answer;
}

std::string metrics(const DaemonProcess& daemon) {
  return page_request(daemon, "GET /metrics HTTP/1.1");
}

/// The value of a metric's sample, as text.
std::string sample(const DaemonProcess& daemon, const std::string& name) {
  const std::string all = metrics(daemon);
  const std::size_t at = all.find('\n' + name + ' ');
  if (at == std::string::npos) return "none";
  const std::size_t begin = at + name.size() + 2;
  return all.substr(begin, all.find('\n', begin) - begin);
}

std::string body_of(const std::string& answer) {
  return answer.substr(answer.find("\r\n\r\n") + 4);
}

const std::string kPictures = "aprsim_requests_total{wire=\"camera.fanuc_table\"}";

TEST(Cameras, StreamPicturesThatAPausedCellRepeatsAndMotionChanges) {
  const DaemonProcess daemon({"--speed", "stepped"});
  CellClient cell(daemon.port("grpc"));
  cell.step(100);
  EXPECT_EQ(sample(daemon, kPictures), "0") << "nobody has asked";

  StreamReader reader(daemon.port("camera.fanuc_table"));
  EXPECT_NE(reader.head().find("Content-Type: multipart/x-mixed-replace; boundary=myboundary\r\n"),
            std::string::npos);
  const std::string first = reader.picture();
  EXPECT_EQ(jpeg_size(first), std::pair(1280, 720));
  EXPECT_EQ(reader.picture(), first);
  EXPECT_EQ(reader.picture(), first);

  v1::SetConveyorRequest forward;
  forward.set_run(true);
  forward.set_direction(v1::CONVEYOR_DIRECTION_FORWARD);
  forward.set_speed_m_s(0.2);
  v1::SetConveyorResponse moving;
  grpc::ClientContext context;
  CellClient::require(cell.control->SetConveyor(&context, forward, &moving));
  cell.step(500);
  std::string later = first;
  for (int i = 0; i < 20 && later == first; ++i) later = reader.picture();
  EXPECT_NE(later, first) << "the belt has moved";
  EXPECT_EQ(jpeg_size(later), std::pair(1280, 720));
}

TEST(Cameras, SendOnePictureOrThePagesPicture) {
  const DaemonProcess daemon({"--speed", "stepped"});
  CellClient cell(daemon.port("grpc"));
  cell.step(70);
  TcpSocket client(daemon.port("camera.motoman_belt"));
  ASSERT_TRUE(client.send("GET /jpg/image.jpg HTTP/1.0\r\n\r\n"));
  std::string answer;
  for (std::string more; !(more = client.receive(TcpSocket::Clock::now() + kLongest)).empty();) {
    answer += more;
  }
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 200 OK\r\n"));
  const std::string jpeg = body_of(answer);
  EXPECT_EQ(jpeg_size(jpeg), std::pair(1280, 720));

  const auto cameras =
      nlohmann::json::parse(body_of(page_request(daemon, "GET /cameras HTTP/1.1")));
  ASSERT_EQ(cameras.size(), 2U);
  EXPECT_EQ(cameras[1]["name"], "motoman_belt");
  EXPECT_EQ(cameras[1]["width"], 1280);
  const std::string same = page_request(daemon, "GET /camera?name=motoman_belt HTTP/1.1");
  EXPECT_NE(same.find("X-Step: 70\r\n"), std::string::npos) << same.substr(0, 500);
  EXPECT_EQ(body_of(same), jpeg);
  EXPECT_TRUE(page_request(daemon, "GET /camera?name=none HTTP/1.1").starts_with("HTTP/1.1 404"));
  EXPECT_TRUE(page_request(daemon, "GET /camera HTTP/1.1").starts_with("HTTP/1.1 404"));
}

TEST(Cameras, ShowAChangedScene) {
  const DaemonProcess daemon({"--speed", "stepped"});
  CellClient cell(daemon.port("grpc"));
  const auto picture = [&] {
    return body_of(page_request(daemon, "GET /camera?name=fanuc_table HTTP/1.1"));
  };
  const std::string before = picture();
  const auto spawned =
      run_process({std::string(APRSIM_BIN_DIR) + "/aprsim", "scene", "spawn", "sku_part_large_gear",
                   "spare", "--at", "0.3", "-1", "1.2", "--ports-file", daemon.ports_file()});
  ASSERT_EQ(spawned.exit_code, 0) << spawned.err;
  EXPECT_NE(picture(), before);
}

TEST(Cameras, AReaderThatTakesNothingDelaysNobody) {
  const DaemonProcess daemon({"--set", "cameras.max_connections=4"});
  StreamReader slow(daemon.port("camera.fanuc_table"), 4096);
  StreamReader quick(daemon.port("camera.fanuc_table"));
  quick.head();
  EXPECT_TRUE(eventually(
      [&] {
        quick.picture();
        const std::string skipped =
            sample(daemon, "aprsim_stream_drops_total{wire=\"camera.fanuc_table\"}");
        return skipped != "0" && skipped != "none";
      },
      kLongest));
}

TEST(Cameras, PicturesOnThePageNeedTheRoleView) {
  const TemporaryDirectory directory;
  directory.write("token", "open sesame\n");
  const DaemonProcess daemon(
      {"--token-file", directory.path() + "/token", "--set", "access.anonymous=none"});
  for (const char* path : {"/cameras", "/camera?name=fanuc_table"}) {
    const std::string get = std::string("GET ") + path + " HTTP/1.1";
    EXPECT_TRUE(page_request(daemon, get).starts_with("HTTP/1.1 401")) << path;
    EXPECT_TRUE(page_request(daemon, get, "Authorization: Bearer open sesame\r\n")
                    .starts_with("HTTP/1.1 200"))
        << path;
  }
}

TEST(Cameras, StoppingTheDaemonEndsStreams) {
  DaemonProcess daemon;
  StreamReader reader(daemon.port("camera.fanuc_table"));
  reader.head();
  reader.picture();
  EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  EXPECT_THROW(while (true) reader.picture(), std::runtime_error);
}

}  // namespace
}  // namespace aprsim::test
