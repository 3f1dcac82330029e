// CRCL against the real daemon, by a client that shares no code with it.

#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "world/robot/kinematics/dynamics.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::test {
namespace {

constexpr double kDegree = M_PI / 180;

std::string actuate(int joint, double degrees) {
  return "<ActuateJoint><JointNumber>" + std::to_string(joint) + "</JointNumber><JointPosition>" +
         std::to_string(degrees) +
         "</JointPosition><JointDetails xsi:type=\"JointSpeedAccelType\"/></ActuateJoint>";
}

double client_x(const std::string& status) { return CrclTextClient::number(status, "X"); }

/// Everything of one robot's lone scene, at its limits and in between.
void expect_every_joint_vector(const std::string& robot) {
  const auto scene = scene::load_scene(robot + "_only", scene::default_data_paths()).value();
  const auto model = robot::load_arm_model(scene.robots[0].model_file).value();
  DaemonProcess daemon({"--scene", robot + "_only", "--speed", "max"});
  CrclTextClient client(daemon.port("crcl." + robot));
  client.run("InitCanonType");
  std::mt19937 random(7);
  for (int round = 0; round < 12; ++round) {
    robot::JointVector q(model.dof());
    std::string fields;
    for (int i = 0; i < model.dof(); ++i) {
      const auto& joint = model.joints[static_cast<std::size_t>(i)];
      const double share = round == 0   ? 0.0
                           : round == 1 ? 1.0
                                        : std::uniform_real_distribution<>(0, 1)(random);
      // To the micro-degree of the text, inside the limits.
      const double lower = std::ceil(joint.lower_rad / kDegree * 1e6) / 1e6;
      const double upper = std::floor(joint.upper_rad / kDegree * 1e6) / 1e6;
      const double degrees =
          std::clamp(std::round((lower + share * (upper - lower)) * 1e6) / 1e6, lower, upper);
      q[i] = degrees * kDegree;
      fields += actuate(i + 1, degrees);
    }
    const std::string status = client.run("ActuateJointsType", fields);
    std::size_t at = 0;
    for (int i = 0; i < model.dof(); ++i) {
      at = status.find("<JointStatus>", at) + 1;
      EXPECT_NEAR(client.number(status, "JointPosition", at), q[i] / kDegree, 1e-6) << status;
    }
    const Eigen::Vector3d p = (scene.robots[0].X_BR.isometry().inverse() *
                               robot::flange_pose(model, q) * scene.robots[0].X_FT.isometry())
                                  .translation() *
                              1e3;
    EXPECT_NEAR(client.number(status, "X"), p.x(), 1e-4);
    EXPECT_NEAR(client.number(status, "Y"), p.y(), 1e-4);
    EXPECT_NEAR(client.number(status, "Z"), p.z(), 1e-4);
  }
}

TEST(Crcl, FanucReachesEveryJointVectorInRange) { expect_every_joint_vector("fanuc"); }
TEST(Crcl, MotomanReachesEveryJointVectorInRange) { expect_every_joint_vector("motoman"); }

TEST(Crcl, AStopFromASecondSocketEndsAMove) {
  DaemonProcess daemon({"--scene", "fanuc_only"});
  CrclTextClient mover(daemon.port("crcl.fanuc")), stopper(daemon.port("crcl.fanuc"));
  mover.run("InitCanonType");
  mover.run("SetTransSpeedType",
            "<TransSpeed xsi:type=\"TransSpeedAbsoluteType\"><Setting>20</Setting></TransSpeed>");
  const double start = client_x(mover.status());
  const auto move = mover.send("MoveToType", "<MoveStraight>true</MoveStraight>" +
                                                 CrclTextClient::tool_down(start + 200, 0, 400));
  EXPECT_EQ(CrclTextClient::field(mover.status(), "CommandState"), "CRCL_Working");
  const auto stop = stopper.send("StopMotionType", "<StopCondition>Fast</StopCondition>");
  const std::string stopped = stopper.wait_done(stop);
  EXPECT_LT(std::abs(client_x(stopped) - start), 150) << "the move ran to its end";
  EXPECT_NE(CrclTextClient::field(mover.status(), "CommandID"), std::to_string(move));
  // A second after it the drives go off, and another motion is obeyed all the same.
  mover.run("EnableRobotParameterStatusType", "<RobotParameterName>drives</RobotParameterName>");
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (CrclTextClient::field(mover.status(), "ParameterValue") != "off") {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
  }
  const double here = client_x(mover.status());
  mover.run("MoveToType",
            "<MoveStraight>true</MoveStraight>" + CrclTextClient::tool_down(here + 5, 0, 400));
  EXPECT_EQ(CrclTextClient::field(mover.status(), "ParameterValue"), "on");
}

TEST(Crcl, AClientGoesOnFromASavedStateInTheMiddleOfAMove) {
  DaemonProcess daemon({"--scene", "fanuc_only", "--speed", "stepped"});
  CrclTextClient client(daemon.port("crcl.fanuc"));
  CellClient cell(daemon.port("grpc"));
  const auto ends = [&](std::int64_t id) {
    for (int i = 0; i < 1000; ++i) {
      const std::string status = client.status();
      const bool done = CrclTextClient::field(status, "CommandState") == "CRCL_Done";
      if (done && CrclTextClient::field(status, "CommandID") == std::to_string(id)) return status;
      cell.step(20);
    }
    throw std::runtime_error("not done: " + client.status());
  };
  const auto move = [&](double y) {
    return client.send("MoveToType", "<MoveStraight>false</MoveStraight>" +
                                         CrclTextClient::tool_down(400, y, 400));
  };
  ends(client.send("InitCanonType"));
  const auto first = move(200);
  client.status();  // answered once the move has been taken
  cell.step(100);
  v1::SaveStateRequest save;
  save.set_name("under way");
  v1::SaveStateResponse saved;
  grpc::ClientContext saving;
  CellClient::require(cell.control->SaveState(&saving, save, &saved));
  const std::string there = client.status();
  ends(first);
  ends(move(-100));
  v1::LoadStateRequest load;
  load.set_name("under way");
  v1::LoadStateResponse loaded;
  grpc::ClientContext loading;
  CellClient::require(cell.control->LoadState(&loading, load, &loaded));
  const std::string back = client.status();
  for (const auto* field : {"CommandID", "CommandState", "X", "Y", "Z"}) {
    EXPECT_EQ(CrclTextClient::field(back, field), CrclTextClient::field(there, field)) << field;
  }
  EXPECT_NEAR(CrclTextClient::number(ends(first), "Y"), 200, 1e-6);
  EXPECT_NEAR(CrclTextClient::number(ends(move(-100)), "Y"), -100, 1e-6);
}

TEST(Crcl, AnUnreachablePoseIsRefusedWithAReasonAndHeldUntilInitCanon) {
  DaemonProcess daemon({"--scene", "fanuc_only"});
  CrclTextClient client(daemon.port("crcl.fanuc"));
  client.run("InitCanonType");
  try {
    client.run("MoveToType",
               "<MoveStraight>false</MoveStraight>" + CrclTextClient::tool_down(5000, 0, 400));
    FAIL() << "five metres away and done";
  } catch (const std::runtime_error& error) {
    const std::string text = CrclTextClient::field(error.what(), "StateDescription");
    EXPECT_NE(text.find("reach"), std::string::npos) << error.what();
  }
  EXPECT_EQ(CrclTextClient::field(client.status(), "CommandState"), "CRCL_Error");
  client.run("InitCanonType");
  EXPECT_EQ(CrclTextClient::field(client.status(), "CommandState"), "CRCL_Done");
}

TEST(Crcl, LengthUnitsScaleTheReportedPoseWithoutMovingIt) {
  DaemonProcess daemon({"--scene", "motoman_only"});
  CrclTextClient client(daemon.port("crcl.motoman"));
  client.run("InitCanonType");
  const double millimetres =
      client_x(client.run("SetLengthUnitsType", "<UnitName>millimeter</UnitName>"));
  const double metres = client_x(client.run("SetLengthUnitsType", "<UnitName>meter</UnitName>"));
  EXPECT_NEAR(metres, millimetres / 1000, 1e-12);
}

TEST(Crcl, ClientsThatVanishFloodOrSendRubbishHarmNobody) {
  DaemonProcess daemon({"--scene", "fanuc_only"});
  const auto port = daemon.port("crcl.fanuc");
  CrclTextClient good(port);
  good.run("InitCanonType");
  {
    CrclTextClient vanishing(port);
    vanishing.send("DwellType", "<DwellTime>60</DwellTime>");
    while (good.status().find("DwellType") == std::string::npos) {
    }
  }
  {
    TcpSocket rubbish(port);
    ASSERT_TRUE(rubbish.send("<CRCLCommandInstance>oops"));
  }
  {
    CrclTextClient flooder(port);
    for (int i = 0; i < 500; ++i) flooder.send("GetStatusType");
  }
  good.run("InitCanonType");
  EXPECT_EQ(good.run("DwellType", "<DwellTime>0.05</DwellTime>").find("CRCL_Error"),
            std::string::npos);
}

}  // namespace
}  // namespace aprsim::test
