// Pictures of the real daemon's cameras over HTTP.

#include <algorithm>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
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

void run_client(const DaemonProcess& daemon, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), std::string(APRSIM_BIN_DIR) + "/aprsim");
  arguments.insert(arguments.end(), {"--ports-file", daemon.ports_file()});
  const auto done = run_process(arguments);
  EXPECT_EQ(done.exit_code, 0) << testing::PrintToString(arguments) << done.err;
}

std::string picture_of(const DaemonProcess& daemon, const std::string& camera) {
  return body_of(page_request(daemon, "GET /camera?name=" + camera + " HTTP/1.1"));
}

TEST(Cameras, InjectedFaultsSpoilPicturesAndEnd) {
  constexpr int kUntilRest = 2000;
  const auto run = [] {
    const DaemonProcess daemon({"--speed", "stepped", "--seed", "5"});
    CellClient cell(daemon.port("grpc"));
    cell.step(kUntilRest);
    const std::string clean = picture_of(daemon, "fanuc_table");
    std::vector<std::string> seen;
    const std::vector<std::vector<std::string>> faults = {{"picture-dirt", "--share", "0.9"},
                                                          {"picture-flicker", "--rate", "100"},
                                                          {"picture-noise"},
                                                          {"picture-quality", "--quality", "5"}};
    for (const auto& fault : faults) {
      std::vector<std::string> inject = {"fault", "inject", fault[0], "fanuc_table"};
      inject.insert(inject.end(), fault.begin() + 1, fault.end());
      run_client(daemon, inject);
      cell.step(5);
      seen.push_back(picture_of(daemon, "fanuc_table"));
      EXPECT_TRUE(seen.back() != clean) << fault[0];
      EXPECT_EQ(jpeg_size(seen.back()), std::pair(1280, 720));
    }
    EXPECT_LT(seen.back().size(), seen[2].size() / 2) << "compressed more";
    run_client(daemon, {"fault", "inject", "picture-outage", "fanuc_table"});
    cell.step(1);
    const std::string out = page_request(daemon, "GET /camera?name=fanuc_table HTTP/1.1");
    EXPECT_TRUE(out.starts_with("HTTP/1.1 503")) << out.substr(0, 200);
    EXPECT_NE(out.find("fanuc_table is out of order"), std::string::npos) << out;
    EXPECT_EQ(jpeg_size(picture_of(daemon, "motoman_belt")), std::pair(1280, 720));
    for (int id = 1; id <= 5; ++id) run_client(daemon, {"fault", "end", std::to_string(id)});
    cell.step(1);
    EXPECT_TRUE(picture_of(daemon, "fanuc_table") == clean) << "nothing has moved";
    return seen;
  };
  EXPECT_TRUE(run() == run()) << "the same seed and steps, the same bits";
}

TEST(Cameras, OnAFlangeMoveWithTheArm) {
  const DaemonProcess daemon({"--speed", "stepped", "--scene", "fanuc_only"});
  CellClient cell(daemon.port("grpc"));
  cell.step(1);
  ASSERT_EQ(cell.cell().cameras_size(), 2);
  EXPECT_EQ(cell.cell().cameras(1).carrier(), "fanuc");
  const auto pose = [&](const std::string& camera) {
    const std::string answer = page_request(daemon, "GET /camera?name=" + camera + " HTTP/1.1");
    const std::size_t at = answer.find("X-Pose: ");
    return at == std::string::npos ? "none" : answer.substr(at, answer.find('\r', at) - at);
  };
  const std::string there = pose("fanuc_tool"), overhead = pose("fanuc_overhead");
  const std::string before = picture_of(daemon, "fanuc_tool");
  EXPECT_EQ(jpeg_size(before), std::pair(640, 480));
  StreamReader reader(daemon.port("camera.fanuc_tool"));
  reader.head();
  EXPECT_TRUE(reader.picture() == before);
  CrclTextClient robot(daemon.port("crcl.fanuc"));
  robot.send("InitCanonType");
  robot.send("ActuateJointsType",
             "<ActuateJoint><JointNumber>1</JointNumber><JointPosition>40</JointPosition>"
             "<JointDetails xsi:type=\"JointSpeedAccelType\"/></ActuateJoint>");
  // The commands come by another wire.
  ASSERT_TRUE(eventually(
      [&] {
        cell.step(100);
        return pose("fanuc_tool") != there;
      },
      kLongest));
  EXPECT_EQ(pose("fanuc_overhead"), overhead);
  EXPECT_TRUE(picture_of(daemon, "fanuc_tool") != before);
  std::string later = before;
  for (int i = 0; i < 20 && later == before; ++i) later = reader.picture();
  EXPECT_TRUE(later != before);
}

TEST(Cameras, AreThoseOfASceneThatIsLoadedLater) {
  const DaemonProcess daemon({"--speed", "stepped", "--scene", "aprs"});
  const std::uint16_t table = daemon.port("camera.fanuc_table");
  const std::uint16_t belt = daemon.port("camera.motoman_belt");
  StreamReader stays(table), ends(belt);
  stays.head();
  ends.head();
  EXPECT_EQ(jpeg_size(stays.picture()), std::pair(1280, 720));
  run_client(daemon, {"reset", "--scene", "aprs_2025"});
  const auto ports = [&] {
    std::ifstream in(daemon.ports_file());
    return nlohmann::json::parse(in, nullptr, false);
  };
  ASSERT_TRUE(eventually([&] { return ports().contains("camera.teach_table"); }, kLongest));
  EXPECT_EQ(ports()["camera.fanuc_table"], table) << "the same name, the same port";
  EXPECT_FALSE(ports().contains("camera.motoman_belt"));
  EXPECT_THROW(while (true) ends.picture(), std::runtime_error);
  std::pair<int, int> size(1280, 720);
  for (int i = 0; i < 100 && size.first == 1280; ++i) size = jpeg_size(stays.picture());
  EXPECT_EQ(size, std::pair(1920, 1080)) << "the stream goes on with the new scene's camera";
  StreamReader teach(ports()["camera.teach_table"].get<std::uint16_t>());
  teach.head();
  EXPECT_EQ(jpeg_size(teach.picture()), std::pair(1280, 960));
  EXPECT_TRUE(
      page_request(daemon, "GET /camera?name=motoman_belt HTTP/1.1").starts_with("HTTP/1.1 404"));
  EXPECT_EQ(nlohmann::json::parse(body_of(page_request(daemon, "GET /cameras HTTP/1.1"))).size(),
            5U);
}

TEST(Cameras, MayHaveAnAddressOfTheirOwn) {
  const DaemonProcess daemon({"--set", "cameras.endpoints.motoman_belt=127.0.0.7:0"});
  EXPECT_NO_THROW(TcpSocket(daemon.port("camera.fanuc_table")));
  EXPECT_THROW(TcpSocket(daemon.port("camera.motoman_belt")), std::runtime_error);
}

TEST(Cameras, MoreMemoryThanTheirLimitIsRefused) {
  const DaemonProcess daemon(
      {"--speed", "stepped", "--scene", "aprs_2025", "--set", "cameras.max_mb=48"});
  const std::string answer = page_request(daemon, "GET /camera?name=fanuc_table HTTP/1.1");
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 503")) << answer.substr(0, 200);
  EXPECT_NE(answer.find("42 MB are too few for the pictures of fanuc_table"), std::string::npos)
      << answer;
}

constexpr auto kLongest_s = std::chrono::duration_cast<std::chrono::seconds>(kLongest);

/// A run of half a second, with dirt on a lens from its middle on. Returns the last picture of the
/// Fanuc's table.
std::string record_a_run(const std::string& journal) {
  DaemonProcess daemon({"--speed", "stepped", "--seed", "5", "--journal", journal});
  CellClient cell(daemon.port("grpc"));
  cell.step(250);
  run_client(daemon, {"fault", "inject", "picture-dirt", "fanuc_table", "--share", "0.9"});
  cell.step(250);
  const std::string last = picture_of(daemon, "fanuc_table");
  EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  return last;
}

TEST(Cameras, AreRenderedAgainFromAJournal) {
  const TemporaryDirectory directory;
  const std::string journal = directory.path() + "/run.journal", file = directory.path() + "/jpegs";
  record_a_run(journal);
  const auto render = [&](const std::string& camera, const std::string& from) {
    return run_process({std::string(APRSIM_BIN_DIR) + "/aprsimd", "--video", file, "--camera",
                        camera, "--motion-rate", "10", "--motion-from", from, "--replay", journal},
                       kLongest_s);
  };
  const auto unknown = render("fanuc_tabel", "0");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("no camera 'fanuc_tabel'; there is fanuc_table, motoman_belt"),
            std::string::npos)
      << unknown.err;
  EXPECT_FALSE(std::filesystem::exists(file));
  const auto empty = render("fanuc_table", "3");
  EXPECT_EQ(empty.exit_code, 2);
  EXPECT_NE(empty.err.find("the chosen time has no picture"), std::string::npos) << empty.err;
  EXPECT_FALSE(std::filesystem::exists(file));
  ASSERT_EQ(render("fanuc_table", "0").exit_code, 0);
  std::ifstream in(file, std::ios::binary);
  const std::string all(std::istreambuf_iterator<char>(in), {});
  std::vector<std::string> pictures;
  for (std::size_t begin = 0; begin < all.size();) {
    const std::size_t end = std::min(all.find("\xff\xd8", begin + 2), all.size());
    pictures.push_back(all.substr(begin, end - begin));
    EXPECT_EQ(jpeg_size(pictures.back()), std::pair(1280, 720));
    begin = end;
  }
  ASSERT_EQ(pictures.size(), 6U) << "at 0, 0.1, ... 0.5 s";
  EXPECT_TRUE(pictures[1] == pictures[2]) << "nothing moves";
  EXPECT_TRUE(pictures[2] != pictures[3]) << "dirt";
  EXPECT_TRUE(pictures[3] == pictures[5]);
}

TEST(Cameras, AVideoShowsWhatACameraSaw) {
  if (run_process({"/usr/bin/env", "ffmpeg", "-version"}).exit_code != 0) {
    GTEST_SKIP() << "ffmpeg, which writes the video, is not installed (Debian package: ffmpeg)";
  }
  const TemporaryDirectory directory;
  const std::string journal = directory.path() + "/run.journal", file = directory.path() + "/v.mp4";
  const std::string jpeg = directory.path() + "/last.jpeg";
  std::ofstream(jpeg, std::ios::binary) << record_a_run(journal);
  const auto done =
      run_process({std::string(APRSIM_BIN_DIR) + "/aprsim", "trace", "export", journal, "--video",
                   "fanuc_table", "--video-file", file, "--rate", "10"},
                  kLongest_s);
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(done.out, file + ": 6 pictures\n");
  const auto probed = run_process(
      {"/usr/bin/env", "ffprobe", "-v", "error", "-count_frames", "-show_entries",
       "stream=codec_name,width,height,r_frame_rate,nb_read_frames", "-of", "csv=p=0", file},
      kLongest_s);
  EXPECT_EQ(probed.out, "h264,1280,720,10/1,6\n") << probed.err;
  const auto grey = [&](const std::string& from, const std::string& filter) {
    const std::string to = directory.path() + "/grey";
    const auto decoded =
        run_process({"/usr/bin/env", "ffmpeg", "-v", "error", "-y", "-i", from, "-vf", filter,
                     "-frames:v", "1", "-f", "rawvideo", "-pix_fmt", "gray", to},
                    kLongest_s);
    EXPECT_EQ(decoded.exit_code, 0) << decoded.err;
    std::ifstream in(to, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string last = grey(file, "select=eq(n\\,5)"), seen = grey(jpeg, "null");
  ASSERT_EQ(last.size(), 1280U * 720U);
  ASSERT_EQ(seen.size(), last.size());
  double sum = 0;
  for (std::size_t i = 0; i < last.size(); ++i) {
    sum += std::abs(static_cast<unsigned char>(last[i]) - static_cast<unsigned char>(seen[i]));
  }
  EXPECT_LT(sum / static_cast<double>(last.size()), 3) << "of 255";
}

}  // namespace
}  // namespace aprsim::test
