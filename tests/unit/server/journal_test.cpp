// A run with its journal, and the same run again.

#include "server/journal/journal.hpp"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "proto/journal/journal_reader.hpp"
#include "server/journal/replay.hpp"
#include "world/scene/scene_loader.hpp"
#include "world/simulation.hpp"
#include "world/state_bytes.hpp"

namespace aprsim::server::journal {
namespace {

using std::chrono::steady_clock;

std::shared_ptr<const scene::Scene> aprs() {
  auto scene = scene::load_scene("aprs", scene::default_data_paths());
  if (!scene) throw std::runtime_error(scene.error().message);
  return std::make_shared<const scene::Scene>(std::move(*scene));
}

JournalOptions options_for(const std::string& place) {
  JournalOptions options;
  options.place = place;
  options.header.set_format(aprsim::journal::kFormat);
  options.header.set_state_version(world::kStateVersion);
  options.header.set_seed(1);
  return options;
}

void submit(world::Simulation& simulation, decltype(api::Command::body) body) {
  const auto ticket = simulation.submit({16, std::move(body)});
  if (!ticket) throw std::runtime_error(ticket.error().message);
}

/// Waits for a step of an epoch.
void wait_for(const world::Simulation& simulation, std::uint64_t epoch, std::uint64_t step) {
  const auto deadline = steady_clock::now() + std::chrono::minutes(4);
  auto seen = simulation.latest();
  while (seen->epoch != epoch || seen->step < step) {
    if (steady_clock::now() > deadline)
      throw std::runtime_error("the simulation has not got there");
    seen = simulation.wait_newer(seen, deadline);
  }
}

class JournalOfARun : public testing::Test {
 protected:
  void SetUp() override {
    directory_ = std::filesystem::temp_directory_path() /
                 ("aprsim-journal-test-" + std::to_string(::getpid()));
    std::filesystem::create_directories(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }
  [[nodiscard]] std::string file() const { return (directory_ / "run.journal").string(); }

  /// Both robots and the belt, a state kept and gone on from, a reset.
  void record(JournalOptions options) {
    Journal journal(std::move(options));
    world::Simulation simulation(
        scene_, {.seed = 1, .speed = std::nullopt, .paused = true, .recorder = &journal});
    simulation.start();
    for (int robot = 0; robot < 2; ++robot) {
      submit(simulation, api::RobotCommand{robot, api::InitRobot{}});
      submit(simulation,
             api::RobotCommand{robot, api::MoveJoints{{{.joint = 0, .position_rad = 0.3}}}});
    }
    submit(simulation, api::ConveyorCommand{.run = true, .forward = true, .speed_m_s = 0.1});
    submit(simulation, api::SimulationCommand(api::StepBy{700}));
    wait_for(simulation, 0, 700);
    submit(simulation, api::SimulationCommand(api::SaveState{"there"}));
    submit(simulation, api::RobotCommand{0, api::StopMotion{}});
    submit(simulation, api::SimulationCommand(api::StepBy{800}));
    wait_for(simulation, 0, 1500);
    submit(simulation, api::SimulationCommand(api::LoadState{"there"}));
    submit(simulation, api::SimulationCommand(api::StepBy{800}));
    wait_for(simulation, 1, 1500);
    submit(simulation, api::SimulationCommand(api::Reset{5}));
    submit(simulation, api::SimulationCommand(api::StepBy{1100}));
    wait_for(simulation, 2, 1100);
    simulation.stop();
    stats_ = journal.stats();
  }

  [[nodiscard]] std::vector<v1::JournalRecord> records() const {
    auto reader = aprsim::journal::JournalReader::open(file());
    if (!reader) throw std::runtime_error(reader.error().message);
    std::vector<v1::JournalRecord> all;
    for (v1::JournalRecord record; reader->next(record);) all.push_back(record);
    EXPECT_EQ(reader->damage(), "");
    return all;
  }

  ReplayResult again(const std::vector<v1::JournalRecord>& all) {
    Replay replay(options_for({}).header, scene_);
    for (const v1::JournalRecord& record : all) {
      const auto goes_on = replay.take(record);
      if (!goes_on) throw std::runtime_error(goes_on.error().message);
      if (!*goes_on) break;
    }
    return replay.result();
  }

  std::shared_ptr<const scene::Scene> scene_ = aprs();
  std::filesystem::path directory_;
  JournalStats stats_;
};

TEST_F(JournalOfARun, IsTheSameAgain) {
  record(options_for(file()));
  const auto all = records();
  EXPECT_TRUE(all.back().has_end());
  const ReplayResult result = again(all);
  EXPECT_FALSE(result.difference) << result.difference->what;
  EXPECT_EQ(result.commands, 6U);
  EXPECT_EQ(result.steps, 1500U + 800U + 1000U);
  EXPECT_GE(result.compared, 3U);
  EXPECT_EQ(result.gaps, 0U);
}

TEST_F(JournalOfARun, IsNotTheSameWithAnotherCommand) {
  record(options_for(file()));
  auto all = records();
  bool changed = false;
  for (v1::JournalRecord& record : all) {
    if (!record.command().robot().has_move_joints() || changed) continue;
    auto& target =
        *record.mutable_command()->mutable_robot()->mutable_move_joints()->mutable_targets(0);
    target.set_position_rad(target.position_rad() + 1e-9);
    changed = true;
  }
  ASSERT_TRUE(changed);
  const ReplayResult result = again(all);
  ASSERT_TRUE(result.difference);
  EXPECT_EQ(result.difference->time, (world::RunTime{0, 1000}));
  EXPECT_NE(result.difference->what.find("joint 1 of"), std::string::npos)
      << result.difference->what;
}

TEST_F(JournalOfARun, GoesOnFromACheckpointAfterLostCommands) {
  record(options_for(file()));
  auto all = records();
  // All that was before the saved state was loaded is lost.
  std::vector<v1::JournalRecord> rest(1);
  rest[0].mutable_gap()->set_commands(1);
  bool behind = false;
  for (const v1::JournalRecord& record : all) {
    behind = behind || (record.has_epoch() && record.epoch().has_loaded_state());
    if (behind) rest.push_back(record);
  }
  ASSERT_TRUE(behind);
  const ReplayResult result = again(rest);
  EXPECT_FALSE(result.difference) << result.difference->what;
  EXPECT_EQ(result.gaps, 1U);
  EXPECT_EQ(result.steps, 800U + 1000U);
}

TEST_F(JournalOfARun, TellsWhereItCannotBeWritten) {
  record(options_for((directory_ / "none" / "run.journal").string()));
  EXPECT_EQ(stats_.records, 0U);
}

}  // namespace
}  // namespace aprsim::server::journal
