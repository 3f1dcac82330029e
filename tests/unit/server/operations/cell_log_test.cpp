#include "server/operations/cell_log.hpp"

#include <memory>

#include <gtest/gtest.h>

namespace aprsim::server {
namespace {

class News : public testing::Test {
 protected:
  News() {
    auto cell = std::make_shared<api::CellDescription>();
    cell->bodies.resize(2);
    cell->bodies[0].name = "tray";
    cell->bodies[1].name = "gear";
    now.cell = std::move(cell);
    now.bodies.resize(2);
  }
  std::string told() {
    std::string all;
    for (const CellLogLine& line : cell_log.detect(now))
      all += (line.error ? "! " : "- ") + line.text + '\n';
    return all;
  }
  CellLog cell_log;
  api::Snapshot now;
};

TEST_F(News, NothingHappensNothingIsTold) {
  EXPECT_EQ(told(), "");
  EXPECT_EQ(told(), "");
}

TEST_F(News, APartIsLostOnceInAnEpoch) {
  now.bodies[1].lost_step = 812;
  EXPECT_EQ(told(), "- gear fell out of the cell in step 812; a reset brings it back\n");
  EXPECT_EQ(told(), "");
  now.epoch = 1;
  now.bodies[1].lost_step.reset();
  EXPECT_EQ(told(), "");
  now.bodies[0].lost_step = 5;
  now.bodies[1].lost_step = 900;
  EXPECT_EQ(told(),
            "- tray fell out of the cell in step 5; a reset brings it back\n"
            "- gear fell out of the cell in step 900; a reset brings it back\n");
}

TEST_F(News, VirtualTimeStandsGoesAndIsLost) {
  api::VirtualTimeState time{.paced = true, .awaited = {"crcl.motoman"}};
  const auto tell = [&] {
    now.virtual_time = std::make_shared<const api::VirtualTimeState>(time);
    return told();
  };
  EXPECT_EQ(tell(), "- virtual time: waits for a request of crcl.motoman\n");
  EXPECT_EQ(tell(), "");
  time = {.paced = true, .pacers = {"crcl.fanuc", "crcl.motoman"}};
  EXPECT_EQ(tell(), "- virtual time: paced by crcl.fanuc, crcl.motoman\n");
  time.expired = 1;
  time.pacers = {"crcl.fanuc"};
  const std::string expired = tell();
  EXPECT_NE(expired.find("time goes on without it (1 times so far)"), std::string::npos) << expired;
  EXPECT_NE(expired.find("paced by crcl.fanuc\n"), std::string::npos) << expired;
  time = {.expired = 1, .fallbacks = 1};
  EXPECT_NE(tell().find("the wall clock does until"), std::string::npos);
}

TEST_F(News, InjectedFaultsBeginAndEnd) {
  auto faults = std::make_shared<api::InjectedFaults>();
  auto& fault = faults->all.emplace_back();
  fault.id = 1;
  fault.kind = faults::Kind::kRobotSlow;
  fault.target = "fanuc";
  now.faults = faults;
  EXPECT_EQ(told(), "") << "it waits";
  faults = std::make_shared<api::InjectedFaults>(*faults);
  faults->all[0].begin_step = 12;
  auto& missing = faults->all.emplace_back();
  missing.id = 2;
  missing.kind = faults::Kind::kPartMissing;
  missing.target = "gear";
  missing.begin_step = missing.end_step = 13;
  now.bodies[1].lost_step = 13;
  now.faults = faults;
  EXPECT_EQ(told(),
            "- injected fault 1: robot-slow fanuc began in step 12\n"
            "- injected fault 2: part-missing gear began in step 13\n")
      << "taken out, not fallen";
  EXPECT_EQ(told(), "");
  faults = std::make_shared<api::InjectedFaults>(*faults);
  faults->all[0].end_step = 99;
  now.faults = faults;
  EXPECT_EQ(told(), "- injected fault 1: robot-slow fanuc ended in step 99\n");
}

TEST_F(News, AStopIsToldEvenIfAResetFollowedAtOnce) {
  now.world_fault = "step 3, body gear: not a number";
  now.world_stops = 1;
  EXPECT_EQ(told(), "! the simulation has stopped: step 3, body gear: not a number\n");
  EXPECT_EQ(told(), "");
  now.epoch = 1;
  now.world_fault.clear();
  EXPECT_EQ(told(), "");
  now.epoch = 3;
  now.world_stops = 2;
  EXPECT_EQ(told(), "! the simulation has stopped: the cell was reset since\n");
}

TEST_F(News, TheSolversFailuresAreToldOncePerEpoch) {
  now.solver_failures.not_converged = 4;
  EXPECT_NE(told().find("above its tolerance"), std::string::npos);
  now.solver_failures.not_converged = 5;
  EXPECT_EQ(told(), "");
  now.epoch = 1;
  EXPECT_NE(told(), "");
}

}  // namespace
}  // namespace aprsim::server
