// `aprsim demo` against the real daemon: each robot's pick and place over the wires alone, watched
// through gRPC by an independent observer.

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "world/scene/data_paths.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::test {
namespace {

struct Vec {
  double x = 0, y = 0, z = 0;
};
double norm(const Vec& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }
Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

Vec position(const v1::Pose& pose) {
  return {pose.position_m().x(), pose.position_m().y(), pose.position_m().z()};
}

/// v rotated by the inverse of q.
Vec unrotate(const v1::Quaternion& q, const Vec& v) {
  const Vec u{-q.x(), -q.y(), -q.z()};
  const auto cross = [](const Vec& a, const Vec& b) {
    return Vec{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  };
  const Vec t = cross(u, v);
  const Vec s = cross(u, t);
  return {v.x + 2 * (q.w() * t.x + s.x), v.y + 2 * (q.w() * t.y + s.y),
          v.z + 2 * (q.w() * t.z + s.z)};
}

/// b's origin in the frame a.
Vec in_frame(const v1::Pose& a, const v1::Pose& b) {
  return unrotate(a.orientation(), position(b) - position(a));
}

/// The path of one gear, observed in the snapshot stream alone.
struct GearStory {
  double start_z = 0, lift_m = 0, slip_m = 0;
  bool carried = false, seen = false;
  std::map<std::string, Vec> in_hand;  ///< by robot, when first carried
};

/// Records the stream until stopped.
class Observer {
 public:
  explicit Observer(CellClient& client) : client_(client), thread_([this] { run(); }) {}
  ~Observer() { finish(); }

  std::map<std::string, GearStory> finish() {
    context_.TryCancel();
    if (thread_.joinable()) thread_.join();
    return stories_;
  }

 private:
  void run() {
    v1::StreamSnapshotsRequest request;
    request.set_rate_hz(500);
    auto stream = client_.telemetry->StreamSnapshots(&context_, request);
    for (v1::StreamSnapshotsResponse response; stream->Read(&response);) see(response.snapshot());
  }

  void see(const v1::Snapshot& snapshot) {
    for (const auto& body : snapshot.bodies()) {
      if (body.kind() != v1::BODY_KIND_GEAR) continue;
      auto& story = stories_[body.name()];
      const double z = body.body_in_world().position_m().z();
      if (!story.seen) story.start_z = z;
      story.seen = true;
      story.lift_m = std::max(story.lift_m, z - story.start_z);
      for (const auto& robot : snapshot.robots()) see_hand(robot, body, z, story);
    }
  }

  static void see_hand(const v1::RobotState& robot, const v1::BodyState& body, double z,
                       GearStory& story) {
    // Transport: in a closed gripper and clear of the trays.
    if (robot.gripper().held_body() != body.name() || z - story.start_z < 0.03) return;
    const Vec p = in_frame(robot.tool_in_world(), body.body_in_world());
    const auto [first, is_new] = story.in_hand.try_emplace(robot.name(), p);
    story.carried = true;
    story.slip_m = std::max(story.slip_m, norm(p - first->second));
  }

  CellClient& client_;
  grpc::ClientContext context_;
  std::map<std::string, GearStory> stories_;
  std::thread thread_;
};

/// Distance from a gear to the nearest slot of a kit tray that takes its type, in the slot's plane
/// and along its axis.
double distance_to_kit_slot(const v1::CellDescription& cell, const v1::Snapshot& snapshot,
                            const v1::BodyState& gear) {
  double best = 1e9;
  for (int i = 0; i < cell.bodies_size(); ++i) {
    if (cell.bodies(i).kind() != v1::BODY_KIND_KIT_TRAY) continue;
    const auto& tray = snapshot.bodies(i);
    const Vec in_tray = in_frame(tray.body_in_world(), gear.body_in_world());
    for (const auto& slot : cell.bodies(i).tray().slots()) {
      if (slot.gear_type() == gear.type()) {
        best = std::min(best, norm(in_tray - position(slot.slot_in_tray())));
      }
    }
  }
  return best;
}

void expect_demo(const std::string& scene, const std::string& robot) {
  DaemonProcess daemon({"--scene", scene, "--speed", "2"});
  CellClient client(daemon.port("grpc"));
  Observer observer(client);
  const auto demo = run_process({std::string(APRSIM_BIN_DIR) + "/aprsim", "--ports-file",
                                 daemon.ports_file(), "demo", "--robot", robot},
                                std::chrono::seconds(100));
  if (scene == "aprs_2025" && robot == "motoman") {
    // As recorded, the kit beside it is full, and the others are beyond its reach.
    EXPECT_EQ(demo.exit_code, 1);
    EXPECT_NE(demo.err.find("reaches no gear that is left in a part tray"), std::string::npos)
        << demo.out << demo.err;
    return;
  }
  ASSERT_EQ(demo.exit_code, 0) << demo.out << demo.err;
  const auto cell = client.cell();
  const auto end = client.wait_for(
      [](const v1::Snapshot& snapshot) {
        for (const auto& body : snapshot.bodies()) {
          if (!body.resting()) return false;
        }
        return true;
      },
      "everything to rest");
  const auto stories = observer.finish();
  int moved = 0;
  for (const auto& body : end.bodies()) {
    if (body.kind() != v1::BODY_KIND_GEAR || !stories.at(body.name()).carried) continue;
    const auto& story = stories.at(body.name());
    ++moved;
    EXPECT_GE(story.lift_m, 0.04) << body.name();
    EXPECT_LT(story.slip_m, 1e-3) << body.name();
    EXPECT_LT(distance_to_kit_slot(cell, end, body), 1e-3) << body.name();
    EXPECT_TRUE(body.resting()) << body.name();
  }
  EXPECT_GE(moved, 1) << "no gear was carried\n" << demo.out;
  EXPECT_EQ(end.physics_faults(), 0U);
  EXPECT_EQ(end.world_fault(), "");
}

struct RobotOfScene {
  std::string scene, robot;
};
void PrintTo(const RobotOfScene& shown, std::ostream* out) {
  *out << shown.scene << ' ' << shown.robot;
}

class DemoInScene : public testing::TestWithParam<RobotOfScene> {};

TEST_P(DemoInScene, ARobotPutsAGearIntoAKit) { expect_demo(GetParam().scene, GetParam().robot); }

/// The robots of every shipped scene in which there is a kit to fill with gears.
std::vector<RobotOfScene> robots_with_kits() {
  std::vector<RobotOfScene> robots;
  const auto paths = scene::default_data_paths();
  for (const auto& name : scene::scene_names(paths)) {
    const auto scene = scene::load_scene(name, paths);
    if (!scene || scene->robots.empty() || scene->gears.empty()) continue;
    const bool kits = std::ranges::any_of(scene->trays, [&](const scene::TrayInstance& tray) {
      return scene->tray_types.at(tray.type).kind == api::BodyKind::kKitTray;
    });
    if (!kits) continue;
    for (const scene::Robot& robot : scene->robots) robots.push_back({name, robot.name});
  }
  return robots;
}

INSTANTIATE_TEST_SUITE_P(Kits, DemoInScene, testing::ValuesIn(robots_with_kits()),
                         [](const auto& test) {
                           return test.param.scene + "_" + test.param.robot;
                         });

TEST(Demo, SomeScenesHaveKits) { EXPECT_GE(robots_with_kits().size(), 6U); }

/// The number after `words` in a text; a failure when they are not there.
double number_after(const std::string& text, const std::string& words) {
  const auto at = text.find(words);
  EXPECT_NE(at, std::string::npos) << words << " is not in\n" << text;
  return at == std::string::npos ? 0 : std::stod(text.substr(at + words.size()));
}

// However fast the simulation goes and however busy the machine is, the belt stops where it is
// wanted: its way decides what the robot reaches, and whether something falls off its end.
TEST(Demo, TheBeltStopsWhereItIsWantedAtTheGreatestPace) {
  DaemonProcess daemon({"--speed", "max"});
  CellClient client(daemon.port("grpc"));
  std::vector<std::unique_ptr<Observer>> observers;
  for (int i = 0; i < 8; ++i) observers.push_back(std::make_unique<Observer>(client));
  const auto demo = run_process({std::string(APRSIM_BIN_DIR) + "/aprsim", "--ports-file",
                                 daemon.ports_file(), "demo", "--belt"},
                                std::chrono::seconds(100));
  ASSERT_EQ(demo.exit_code, 0) << demo.out << demo.err;
  EXPECT_NEAR(number_after(demo.out, "belt: ran "), number_after(demo.out, "before the motoman, "),
              20);
  const auto end = client.snapshot();
  EXPECT_FALSE(end.has_speed_target()) << "as fast as before";
  EXPECT_EQ(end.physics_faults(), 0U);
}

}  // namespace
}  // namespace aprsim::test
