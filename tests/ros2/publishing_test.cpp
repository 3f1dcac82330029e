// aprsim-ros2 beside the real daemon, read by Fast DDS: a second implementation, which knows
// nothing of the program but topics and bytes.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/ros2/ros2_fixture.hpp"
#include "tests/support/cell_client.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

const std::string kJointState = "sensor_msgs::msg::dds_::JointState_";
const std::string kTf = "tf2_msgs::msg::dds_::TFMessage_";

struct ReadJoints {
  double time = 0;
  std::vector<std::string> name;
  std::vector<double> position, velocity, effort;
};

ReadJoints read_joints(const std::vector<unsigned char>& sample) {
  CdrReader in(sample);
  ReadJoints joints;
  joints.time = in.time();
  EXPECT_EQ(in.text(), "");
  joints.name = in.texts();
  joints.position = in.doubles();
  joints.velocity = in.doubles();
  joints.effort = in.doubles();
  EXPECT_TRUE(in.at_end());
  return joints;
}

/// The children of a TFMessage's transforms, with their translations and rotations.
std::map<std::string, std::array<double, 7>> read_frames(const std::vector<unsigned char>& sample) {
  CdrReader in(sample);
  std::map<std::string, std::array<double, 7>> frames;
  const auto count = in.number<std::uint32_t>();
  for (std::uint32_t i = 0; i < count; ++i) {
    in.time();
    EXPECT_EQ(in.text(), "world");
    auto& frame = frames[in.text()];
    for (auto& value : frame) value = in.number<double>();
  }
  EXPECT_TRUE(in.at_end());
  return frames;
}

TEST_F(Ros2, FastDdsDiscoversTopicsWithNamesTypesAndHashesOfJazzy) {
  // Type hashes as nodes of Jazzy report them.
  const std::map<std::string, std::pair<std::string, std::string>> expected = {
      {"rt/clock",
       {"rosgraph_msgs::msg::dds_::Clock_",
        "typehash=RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564;"}},
      {"rt/joint_states",
       {kJointState,
        "typehash=RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e;"}},
      {"rt/fanuc/joint_states",
       {kJointState,
        "typehash=RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e;"}},
      {"rt/tf",
       {kTf, "typehash=RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087;"}},
      {"rt/tf_static",
       {kTf, "typehash=RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087;"}},
  };
  ASSERT_TRUE(eventually(
      [&] {
        std::this_thread::sleep_for(5ms);
        const auto writers = fast_dds_->writers();
        return std::ranges::all_of(
            expected, [&](const auto& topic) { return writers.contains(topic.first); });
      },
      kLongest));
  auto writers = fast_dds_->writers();
  for (const auto& [topic, type] : expected) {
    EXPECT_EQ(writers[topic].type, type.first) << topic;
    EXPECT_EQ(writers[topic].user_data, type.second) << topic;
    EXPECT_TRUE(writers[topic].reliable) << topic;
    EXPECT_EQ(writers[topic].transient_local, topic == "rt/tf_static") << topic;
  }
  EXPECT_EQ(writers["ros_discovery_info"].type,
            "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_");
  EXPECT_EQ(program_->stop(SIGTERM), 0);
}

TEST_F(Ros2, JointsEqualTheDaemonsSnapshotAndTimeAdvances) {
  fast_dds_->subscribe("rt/joint_states", kJointState, false);
  fast_dds_->subscribe("rt/clock", "rosgraph_msgs::msg::dds_::Clock_", false);
  CellClient client(daemon_->port("grpc"));
  std::uint64_t steps = 0;
  for (int i = 0; i < 3; ++i) {
    client.step(250);
    steps += 250;
    const double time = 1e-3 * static_cast<double>(steps);
    ASSERT_TRUE(take_until("rt/clock", [&](const auto& sample) {
      return std::abs(CdrReader(sample).time() - time) < 1e-9;
    }));
    ReadJoints joints;
    ASSERT_TRUE(take_until("rt/joint_states", [&](const auto& sample) {
      joints = read_joints(sample);
      return std::abs(joints.time - time) < 1e-9;
    }));
    const auto snapshot = client.snapshot();
    ASSERT_EQ(snapshot.step(), steps);
    const auto cell = client.cell();
    std::size_t at = 0;
    for (int r = 0; r < snapshot.robots_size(); ++r) {
      for (int j = 0; j < snapshot.robots(r).joints_size(); ++j, ++at) {
        ASSERT_LT(at, joints.position.size());
        const auto& joint = snapshot.robots(r).joints(j);
        EXPECT_TRUE(joints.name[at].ends_with(cell.robots(r).joints(j).name()));
        EXPECT_EQ(joints.position[at], joint.position_rad());
        EXPECT_EQ(joints.velocity[at], joint.velocity_rad_s());
        EXPECT_EQ(joints.effort[at], joint.torque_nm());
      }
    }
    EXPECT_EQ(at, joints.position.size());
  }
}

TEST_F(Ros2, FramesEqualTheDaemonsSnapshot) {
  fast_dds_->subscribe("rt/tf", kTf, false);
  fast_dds_->subscribe("rt/tf_static", kTf, true);
  CellClient client(daemon_->port("grpc"));
  const auto snapshot = client.snapshot();
  std::map<std::string, std::array<double, 7>> moving, fixed;
  ASSERT_TRUE(take_until("rt/tf", [&](const auto& sample) {
    moving = read_frames(sample);
    return true;
  }));
  ASSERT_TRUE(take_until("rt/tf_static", [&](const auto& sample) {
    fixed = read_frames(sample);
    return true;
  }));
  const auto as_array = [](const v1::Pose& pose) {
    const auto& p = pose.position_m();
    const auto& q = pose.orientation();
    return std::array<double, 7>{p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
  };
  for (const auto& robot : snapshot.robots()) {
    EXPECT_EQ(moving[robot.name() + "_tool"], as_array(robot.tool_in_world()));
  }
  for (const auto& body : snapshot.bodies()) {
    EXPECT_EQ(moving[body.name()], as_array(body.body_in_world())) << body.name();
  }
  const auto cell = client.cell();
  for (const auto& robot : cell.robots()) {
    EXPECT_EQ(fixed[robot.name() + "_base"], as_array(robot.base_in_world()));
  }
}

TEST_F(Ros2, EndsInOrderWithoutADaemon) {
  fast_dds_->subscribe("rt/clock", "rosgraph_msgs::msg::dds_::Clock_", false);
  const auto any = [](const auto&) { return true; };
  ASSERT_TRUE(take_until("rt/clock", any));
  daemon_->stop(SIGKILL);
  while (!fast_dds_->take("rt/clock").empty()) continue;
  EXPECT_EQ(program_->stop(SIGTERM), 0);  // also while there is no daemon
}

TEST(Ros2Program, NamesWrongArguments) {
  const auto domain = run_process({kProgram, "--domain", "300"});
  EXPECT_EQ(domain.exit_code, 2);
  EXPECT_NE(domain.err.find("--domain"), std::string::npos) << domain.err;
  EXPECT_NE(domain.err.find("300"), std::string::npos) << domain.err;
  const auto space = run_process({kProgram, "--namespace", "a-b"});
  EXPECT_EQ(space.exit_code, 2);
  EXPECT_NE(space.err.find("a-b"), std::string::npos) << space.err;
  const auto file = run_process({kProgram, "--ports-file", "/nonexistent/ports.json"});
  EXPECT_EQ(file.exit_code, 2);
  EXPECT_NE(file.err.find("/nonexistent/ports.json"), std::string::npos) << file.err;
}

}  // namespace
}  // namespace aprsim::test
