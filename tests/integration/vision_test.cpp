// The vision feed of the real daemon, read by a parser that shares no code with it, against the
// bodies' poses over gRPC.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/temporary_directory.hpp"
#include "tests/support/vision_client.hpp"

namespace aprsim::test {
namespace {

constexpr double kNoise_mm = 0.5;
constexpr double kTurnNoise_rad = 1 * M_PI / 180;
constexpr double kClip = 3.5;                           // standard deviations at which noise is cut
constexpr double kRounding_mm = 0.0006;                 // of the text
constexpr std::uint64_t kPeriod = 100, kLatency = 200;  // steps of 1 ms
constexpr double kSpeed_m_s = 0.15;

/// Two robots that stand apart and a belt between them with trays and gears; cameras that look down
/// on the belt from beside the arms, with these tests' noise, rate and latency.
std::string vision_scene_text() {
  const std::string types = std::string(APRSIM_SOURCE_DIR) + "/world/scenes/types/";
  const std::string camera =
      "rate_hz: 10, latency_s: 0.2, position_noise_m: 0.0005, rotation_noise_deg: 1}\n";
  return "types: [" + types + "gears_2017.yaml, " + types + "robots.yaml]\n" +
         "robots:\n"
         "  - name: fanuc\n    type: fanuc_lrmate200id\n    base: {xyz_m: [0, -1.6, 0.9]}\n"
         "    vision: {frame: {xyz_m: [0.1, 0.2, 0], rpy_deg: [0, 0, 30]},\n"
         "      area: {min_m: [-3, -3], max_m: [3, 3]}, camera_m: [0.8, 1.2, 3], shuffle: true, " +
         camera +
         "  - name: motoman\n    type: motoman_sia20\n    base: {xyz_m: [0, 1.8, 0.9]}\n"
         "    vision: {area: {min_m: [-3, -3], max_m: [3, 3]}, camera_m: [0, -1.8, 3], " +
         camera +
         "conveyor: {xyz_m: [0, 0, 0.9], length_m: 3, width_m: 0.6, max_speed_m_s: 0.3, "
         "max_accel_m_s2: 0.5}\n"
         "trays:\n"
         "  - {name: large, type: sku_large_gear_vessel, on: conveyor, xy_m: [-1.1, 0.1],\n"
         "     gears: {slot_1: large_1, slot_2: large_2}}\n"
         "  - {name: small, type: sku_small_gear_vessel, on: conveyor, xy_m: [-0.8, -0.1],\n"
         "     yaw_deg: 100, gears: {slot_1: small_1, slot_3: small_2}}\n"
         "  - {name: kit, type: sku_kit_s2l2_vessel, on: conveyor, xy_m: [-0.4, 0],\n"
         "     yaw_deg: -130}\n";
}

/// Position and heading in a plane.
struct Place {
  double x = 0, y = 0, angle = 0;
};

/// The place and heading of a pose whose z axis points up.
Place place_of(const v1::Pose& pose) {
  const auto& q = pose.orientation();
  return {pose.position_m().x(), pose.position_m().y(), 2 * std::atan2(q.z(), q.w())};
}

/// `b` seen from `a`, both given in the same frame.
Place seen_from(const Place& a, const Place& b) {
  const double dx = b.x - a.x, dy = b.y - a.y;
  return {std::cos(a.angle) * dx + std::sin(a.angle) * dy,
          -std::sin(a.angle) * dx + std::cos(a.angle) * dy, b.angle - a.angle};
}

Place chained(const Place& a, const Place& b) {
  return {a.x + std::cos(a.angle) * b.x - std::sin(a.angle) * b.y,
          a.y + std::sin(a.angle) * b.x + std::cos(a.angle) * b.y, a.angle + b.angle};
}

Place vision_frame(const v1::RobotDescription& robot) {
  return chained(chained(place_of(robot.base_in_world()), place_of(robot.reference_in_base())),
                 place_of(robot.vision_in_reference()));
}

std::string type_code(v1::BodyKind kind) {
  return kind == v1::BODY_KIND_GEAR ? "P" : kind == v1::BODY_KIND_KIT_TRAY ? "KT" : "PT";
}

/// A daemon whose time the test steps, with one reader on each feed.
class Vision : public testing::Test {
 protected:
  struct Feed {
    Place X_WV;
    std::unique_ptr<VisionClient> reader;
    std::string line;
  };

  Vision() {
    const auto cell = client.cell();
    for (const auto& robot : cell.robots()) {
      feeds.push_back({vision_frame(robot),
                       std::make_unique<VisionClient>(daemon.port("vision." + robot.name())), ""});
      feeds.back().line = feeds.back().reader->line();
    }
    exposures[0] = client.snapshot();
    for (std::uint64_t step = 0; step < kLatency; step += kPeriod) expose();
  }

  /// Runs to the next exposure.
  const v1::Snapshot& expose() {
    client.step(kPeriod);
    const auto now = client.snapshot();
    return exposures[now.step()] = now;
  }

  /// Runs to the next exposure, and reads the frames that come out then.
  const v1::Snapshot& next_frames() {
    const auto& now = expose();
    for (auto& feed : feeds) feed.line = feed.reader->line_after(feed.line);
    return now;
  }

  void run_belt() {
    v1::SetConveyorRequest request;
    request.set_run(true);
    request.set_direction(v1::CONVEYOR_DIRECTION_FORWARD);
    request.set_speed_m_s(kSpeed_m_s);
    v1::SetConveyorResponse response;
    grpc::ClientContext context;
    CellClient::require(client.control->SetConveyor(&context, request, &response));
  }

  /// Each body once, where it was at `truth`; adds the errors' squares.
  void expect_all(const Feed& feed, const v1::Snapshot& truth) {
    auto objects = parse_vision_line(feed.line);
    ASSERT_EQ(objects.size(), static_cast<std::size_t>(truth.bodies_size())) << feed.line;
    for (const auto& body : truth.bodies()) {
      const Place place = seen_from(feed.X_WV, place_of(body.body_in_world()));
      const auto distance = [&](const VisionObject& object) {
        return std::hypot(object.x_mm - place.x * 1e3, object.y_mm - place.y * 1e3);
      };
      const auto nearest = std::min_element(
          objects.begin(), objects.end(), [&](const VisionObject& a, const VisionObject& b) {
            const bool same_a = a.name == body.type(), same_b = b.name == body.type();
            return same_a != same_b ? same_a : distance(a) < distance(b);
          });
      ASSERT_EQ(nearest->name, body.type()) << feed.line;
      EXPECT_EQ(nearest->type, type_code(body.kind()));
      const double dx = nearest->x_mm - place.x * 1e3, dy = nearest->y_mm - place.y * 1e3;
      EXPECT_LE(std::abs(dx), kClip * kNoise_mm + kRounding_mm) << body.name();
      EXPECT_LE(std::abs(dy), kClip * kNoise_mm + kRounding_mm) << body.name();
      const double turn = std::remainder(nearest->rotation_rad - place.angle, 2 * M_PI);
      EXPECT_LE(std::abs(turn), kClip * kTurnNoise_rad + 1e-4) << body.name();
      EXPECT_EQ(nearest->score, 1);
      squares += dx * dx + dy * dy;
      count += 2;
      objects.erase(nearest);
    }
  }

  TemporaryDirectory directory;
  DaemonProcess daemon{
      {"--scene", directory.write("belt.yaml", vision_scene_text()), "--speed", "stepped"}};
  CellClient client{daemon.port("grpc")};
  std::vector<Feed> feeds;
  std::map<std::uint64_t, v1::Snapshot> exposures;  ///< by step
  double squares = 0;
  int count = 0;
};

TEST_F(Vision, EveryPartIsRecoveredWithinTheNoiseWhileBeltAndArmsMove) {
  // Turning about their bases, the arms stay out of the cameras' way.
  CrclTextClient fanuc(daemon.port("crcl.fanuc")), motoman(daemon.port("crcl.motoman"));
  const auto turn = [this](CrclTextClient& robot) {
    robot.send("InitCanonType");
    robot.status();  // what was sent before has been taken once this is answered
    next_frames();
    robot.send("ActuateJointsType",
               "<ActuateJoint><JointNumber>1</JointNumber><JointPosition>-90</JointPosition>"
               "<JointDetails xsi:type=\"JointSpeedAccelType\"><JointSpeed>20</JointSpeed>"
               "</JointDetails></ActuateJoint>");
    robot.status();
  };
  turn(fanuc);
  turn(motoman);
  run_belt();
  bool moved[2] = {false, false};
  for (int k = 1; k <= 40; ++k) {
    const auto& now = next_frames();
    for (int i = 0; i < 2; ++i) moved[i] = moved[i] || now.robots(i).moving();
    const auto& truth = exposures.at(now.step() - kLatency);
    for (const auto& feed : feeds) expect_all(feed, truth);
  }
  EXPECT_TRUE(moved[0] && moved[1]) << "the arms stood still";
  EXPECT_GT(exposures.rbegin()->second.conveyor().travel_m(), 0.4) << "the belt stood still";
  EXPECT_NEAR(std::sqrt(squares / count), kNoise_mm, 0.05) << "noise as configured";
}

TEST_F(Vision, AMovingPartShowsWithTheConfiguredLatency) {
  run_belt();
  for (int k = 0; k < 10; ++k) next_frames();  // up to speed
  const double v_mm_s = client.snapshot().conveyor().speed_m_s() * 1e3;
  EXPECT_NEAR(v_mm_s, kSpeed_m_s * 1e3, 1e-6);
  double lag_sum = 0;
  int samples = 0;
  for (int k = 0; k < 30; ++k) {
    const auto& now = next_frames();
    for (const auto& object : parse_vision_line(feeds[1].line)) {
      if (object.name != "sku_kit_s2l2_vessel") continue;
      const double x_mm = place_of(now.bodies(2).body_in_world()).x * 1e3;
      lag_sum += (x_mm - object.x_mm) / v_mm_s;
      ++samples;
    }
  }
  ASSERT_EQ(samples, 30);
  // Standard error: 0.5 mm / sqrt(30) at 150 mm/s is 0.6 ms.
  EXPECT_NEAR(lag_sum / samples, kLatency * 1e-3, 0.003);
}

TEST_F(Vision, APausedCellStillSendsAndAClientThatNeverReadsHarmsNobody) {
  VisionClient silent(daemon.port("vision.fanuc"), 4096);
  const auto before = std::chrono::steady_clock::now();
  std::string line = feeds[0].line;
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(feeds[0].reader->line(std::chrono::milliseconds(500)), line);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(2));
  VisionClient late(daemon.port("vision.fanuc"));
  EXPECT_EQ(late.line(std::chrono::milliseconds(300)), line) << "at once, not at the next frame";
}

TEST_F(Vision, TheSnapshotCarriesTheSameDetections) {
  const auto now = next_frames();
  for (int i = 0; i < 2; ++i) {
    const auto objects = parse_vision_line(feeds[static_cast<std::size_t>(i)].line);
    const auto& frame = now.robots(i).vision();
    ASSERT_EQ(frame.detections_size(), static_cast<int>(objects.size()));
    for (int k = 0; k < frame.detections_size(); ++k) {
      const auto& object = objects[static_cast<std::size_t>(k)];
      EXPECT_NEAR(frame.detections(k).x_m() * 1e3, object.x_mm, kRounding_mm);
      EXPECT_NEAR(frame.detections(k).rotation_rad(), object.rotation_rad, 1e-4);
    }
  }
}

TEST(VisionAndRobot, APartIsPickedWhereTheFeedPutsIt) {
  DaemonProcess daemon({"--scene", "aprs", "--speed", "max"});
  CellClient client(daemon.port("grpc"));
  VisionClient vision(daemon.port("vision.fanuc"));
  const auto cell = client.cell();
  // The medium gear nearest to the robot, by its name on the feed alone; the height is the tray's.
  VisionObject part;
  for (const auto& object : parse_vision_line(vision.line())) {
    if (object.name != "sku_part_medium_gear") continue;
    if (!part.seen || object.x_mm < part.x_mm) part = object;
  }
  ASSERT_TRUE(part.seen);
  double start_z_m = 0, z_mm = 0;
  for (int i = 0; i < cell.bodies_size(); ++i) {
    if (cell.bodies(i).type() != part.name) continue;
    const auto& gear = cell.bodies(i).gear();
    start_z_m = client.snapshot().bodies(i).body_in_world().position_m().z();
    z_mm = (start_z_m + gear.disc_height_m() + 0.004 -
            cell.robots(0).base_in_world().position_m().z() -
            cell.robots(0).reference_in_base().position_m().z()) *
           1e3;
  }
  CrclTextClient robot(daemon.port("crcl.fanuc"));
  const auto move = [&](double up_mm, bool straight) {
    robot.run("MoveToType", std::string("<MoveStraight>") + (straight ? "true" : "false") +
                                "</MoveStraight>" +
                                CrclTextClient::tool_down(part.x_mm, part.y_mm, z_mm + up_mm));
  };
  robot.run("InitCanonType");
  robot.run("SetEndEffectorType", "<Setting>1</Setting>");
  robot.run("SetTransSpeedType",
            "<TransSpeed xsi:type=\"TransSpeedAbsoluteType\"><Setting>120</Setting></TransSpeed>");
  move(60, false);
  move(0, true);
  robot.run("SetEndEffectorType", "<Setting>0</Setting>");
  robot.run("DwellType", "<DwellTime>0.3</DwellTime>");
  move(60, true);
  const auto after = client.snapshot();
  EXPECT_TRUE(after.robots(0).gripper().holding());
  bool lifted = false;
  for (const auto& body : after.bodies()) {
    if (body.name() != after.robots(0).gripper().held_body()) continue;
    EXPECT_EQ(body.type(), part.name);
    lifted = body.body_in_world().position_m().z() > start_z_m + 0.05;
  }
  EXPECT_TRUE(lifted);
}

ProcessResult print_config(const std::vector<std::string>& settings) {
  std::vector<std::string> argv = {std::string(APRSIM_BIN_DIR) + "/aprsimd", "--print-config"};
  for (const auto& setting : settings) argv.insert(argv.end(), {"--set", setting});
  return run_process(argv);
}

TEST(VisionConfig, IsReadShownAndChecked) {
  const auto shown =
      print_config({"vision.ports.fanuc=5001", "vision.empty_slots=true", "vision.repeat_s=0.3"});
  EXPECT_EQ(shown.exit_code, 0) << shown.err;
  for (const char* line : {"fanuc: 5001", "motoman: 4001", "empty_slots: true", "repeat_s: 0.3"}) {
    EXPECT_NE(shown.out.find(line), std::string::npos) << line << " in " << shown.out;
  }
  for (const std::string key : {"ports.fanuc=65536", "repeat_s=0", "repeat_s=0.6",
                                "max_connections=0", "empty_slots=maybe", "rate=3"}) {
    const auto refused = print_config({"vision." + key});
    EXPECT_NE(refused.exit_code, 0) << key;
    const std::string name = "vision." + key.substr(0, key.find('='));
    EXPECT_NE(refused.err.find(name), std::string::npos) << refused.err;
  }
}

}  // namespace
}  // namespace aprsim::test
