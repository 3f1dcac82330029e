// A run with its journal, and the same run again.

#include "server/journal/journal.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "proto/journal/journal_reader.hpp"
#include "server/journal/digest.hpp"
#include "server/journal/recorded_scenes.hpp"
#include "server/journal/run_header.hpp"
#include "server/replay/replay.hpp"
#include "world/cell/state_bytes.hpp"
#include "world/runtime/simulation.hpp"
#include "world/scene/scene_loader.hpp"

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
      const auto goes_on = replay.process(record);
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
  EXPECT_FALSE(result.difference) << result.difference->text;
  EXPECT_EQ(result.commands, 6U);
  EXPECT_EQ(result.steps, 1500U + 800U + 1000U);
  EXPECT_GE(result.compared, 3U);
  EXPECT_EQ(result.gaps, 0U);
}

TEST_F(JournalOfARun, HasTheEventsOfTheCell) {
  record(options_for(file()));
  std::uint64_t last = 0;
  std::vector<v1::CellEventKind> kinds;
  for (const v1::JournalRecord& record : records()) {
    if (!record.has_event()) continue;
    EXPECT_EQ(record.event().sequence(), last + 1);
    last = record.event().sequence();
    kinds.push_back(record.event().kind());
  }
  for (const auto kind : {v1::CELL_EVENT_KIND_COMMAND_BEGUN, v1::CELL_EVENT_KIND_RESET}) {
    EXPECT_NE(std::ranges::find(kinds, kind), kinds.end()) << v1::CellEventKind_Name(kind);
  }
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
  EXPECT_NE(result.difference->text.find("joint 1 of"), std::string::npos)
      << result.difference->text;
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
  EXPECT_FALSE(result.difference) << result.difference->text;
  EXPECT_EQ(result.gaps, 1U);
  EXPECT_EQ(result.steps, 800U + 1000U);
}

TEST_F(JournalOfARun, HasCheckpointsThatAreComparedByteForByte) {
  {
    Journal journal(options_for(file()));
    world::Simulation simulation(
        scene_, {.seed = 1, .speed = std::nullopt, .paused = true, .recorder = &journal});
    simulation.start();
    submit(simulation, api::RobotCommand{0, api::InitRobot{}});
    submit(simulation, api::SimulationCommand(api::StepBy{10'500}));
    wait_for(simulation, 0, 10'500);
    simulation.stop();
  }
  const auto all = records();
  EXPECT_FALSE(again(all).difference);
  const auto checkpoint = std::ranges::find_if(all, [](const v1::JournalRecord& record) {
    return record.has_checkpoint() && record.checkpoint().time().step() == 10'000;
  });
  ASSERT_NE(checkpoint, all.end());
  // States that can be read, with the hash that was recorded, and another number somewhere.
  RecordedScenes scenes(scene_);
  const std::string& bytes = checkpoint->checkpoint().state();
  int tried = 0;
  for (std::size_t at = bytes.size() / 200; at < bytes.size() && tried < 5;
       at += bytes.size() / 200) {
    auto changed = all;
    auto& other = *changed[static_cast<std::size_t>(checkpoint - all.begin())].mutable_checkpoint();
    (*other.mutable_state())[at] ^= 1;
    other.set_state_sha256(sha256(other.state()));
    const auto state = scenes.state_of(other);
    if (!state || world::to_bytes(*state) == bytes) continue;
    ++tried;
    const ReplayResult result = again(changed);
    ASSERT_TRUE(result.difference) << "byte " << at;
    EXPECT_EQ(result.difference->time, (world::RunTime{0, 10'000}));
    EXPECT_NE(result.difference->text.find("differs at byte"), std::string::npos)
        << result.difference->text;
  }
  EXPECT_GE(tried, 3);
}

TEST_F(JournalOfARun, HasWhatListenersRefusedAsEvents) {
  {
    Journal journal(options_for(file()));
    journal.began({2, 0}, 1, nullptr, scene_);
    api::Snapshot seen;
    seen.epoch = 2;
    seen.step = 1500;
    seen.time = std::chrono::milliseconds(1500);
    journal.refused(seen, "modbus", "function 6: exception 2");
  }
  const auto all = records();
  const auto found = std::ranges::find_if(all, &v1::JournalRecord::has_event);
  ASSERT_NE(found, all.end());
  EXPECT_EQ(found->event().kind(), v1::CELL_EVENT_KIND_REFUSED);
  EXPECT_EQ(found->event().epoch(), 2U);
  EXPECT_EQ(found->event().step(), 1500U);
  EXPECT_EQ(found->event().names(0), "modbus");
  EXPECT_EQ(found->event().text(), "function 6: exception 2");
}

TEST(JournalCautions, TellOfAnotherBuildAndNotOfTheSame) {
  v1::JournalHeader here = header_here(), then = here;
  EXPECT_EQ(here.world_sha256().size(), 64U);
  EXPECT_TRUE(cautions(then, here).empty());
  then.set_world_sha256(std::string(64, 'a'));
  then.set_build("flags '-ffast-math'");
  const auto all = cautions(then, here);
  ASSERT_EQ(all.size(), 2U);
  EXPECT_NE(all[0].find("other sources"), std::string::npos) << all[0];
  EXPECT_NE(all[0].find(here.world_sha256().substr(0, 12)), std::string::npos) << all[0];
  EXPECT_NE(all[1].find("-ffast-math"), std::string::npos) << all[1];
  // Older journals do not tell.
  then.clear_world_sha256();
  EXPECT_TRUE(cautions(then, here).empty());
}

TEST_F(JournalOfARun, TellsWhereItCannotBeWritten) {
  record(options_for((directory_ / "none" / "run.journal").string()));
  EXPECT_EQ(stats_.records, 0U);
}

/// The file of an incident.
std::string bytes_of(Journal& journal, std::chrono::nanoseconds last) {
  std::promise<Result<protocols::Incident>> promise;
  journal.take_incident(
      last, [&](Result<protocols::Incident> incident) { promise.set_value(std::move(incident)); });
  auto future = promise.get_future();
  if (future.wait_for(std::chrono::minutes(1)) != std::future_status::ready) {
    throw std::runtime_error("no incident came");
  }
  const auto incident = future.get();
  if (!incident) throw std::runtime_error(incident.error().message);
  std::string bytes;
  for (const auto& piece : incident->pieces) bytes += *piece;
  return bytes;
}

TEST_F(JournalOfARun, IsInMemoryFromEveryCheckpointOn) {
  Journal journal(options_for({}));
  world::Simulation simulation(
      scene_, {.seed = 1, .speed = std::nullopt, .paused = true, .recorder = &journal});
  simulation.start();
  submit(simulation, api::RobotCommand{0, api::InitRobot{}});
  for (std::uint64_t second = 0; second < 45; ++second) {
    const double target_rad = second % 2 == 0 ? 0.4 : -0.4;
    submit(simulation,
           api::RobotCommand{0, api::MoveJoints{{{.joint = 0, .position_rad = target_rad}}}});
    submit(simulation, api::SimulationCommand(api::StepBy{1000}));
    wait_for(simulation, 0, 1000 * (second + 1));
  }
  std::size_t last_size = 0;
  // Checkpoints are at 40, 30, ... s, and the beginning is one.
  for (const auto& [last_s, from] : std::vector<std::pair<int, std::uint64_t>>{
           {1, 40'000}, {5, 40'000}, {6, 30'000}, {20, 20'000}, {45, 0}, {600, 0}}) {
    const std::string bytes = bytes_of(journal, std::chrono::seconds(last_s));
    EXPECT_GE(bytes.size() + 64, last_size);  // equal ones are compressed a little differently
    last_size = bytes.size();
    std::ofstream(file(), std::ios::binary) << bytes;
    const auto all = records();
    ASSERT_FALSE(all.empty());
    const auto& first = all.front();
    EXPECT_EQ(first.has_epoch() ? first.epoch().time().step() : first.checkpoint().time().step(),
              from)
        << last_s;
    const ReplayResult result = again(all);
    EXPECT_FALSE(result.difference) << result.difference->text;
    EXPECT_EQ(result.steps, 45'000 - from);
    EXPECT_GE(result.compared, (45'000 - from) / 1000);
  }
  simulation.stop();
  EXPECT_EQ(journal.stats().records, 0U);
  EXPECT_GE(journal.stats().memory_bytes, last_size - 1000);
}

TEST_F(JournalOfARun, IsKeptInMemoryBesideAFileThatCannotBeWritten) {
  Journal journal(options_for((directory_ / "none" / "run.journal").string()));
  world::Simulation simulation(scene_, {.speed = std::nullopt, .recorder = &journal});
  simulation.start();
  wait_for(simulation, 0, 1500);
  simulation.stop();
  std::ofstream(file(), std::ios::binary) << bytes_of(journal, std::chrono::seconds(60));
  const auto all = records();
  EXPECT_TRUE(std::ranges::none_of(all, &v1::JournalRecord::has_gap));
  EXPECT_FALSE(again(all).difference);
}

TEST_F(JournalOfARun, WiresThatFloodItAreToldAsAGapAndLoseNoCommand) {
  JournalOptions options = options_for(file());
  options.max_queue_bytes = 1 << 20;
  {
    Journal journal(std::move(options));
    world::Simulation simulation(
        scene_, {.seed = 1, .speed = std::nullopt, .paused = true, .recorder = &journal});
    simulation.start();
    const auto connection = std::make_shared<const protocols::WireConnection>();
    submit(simulation, api::RobotCommand{0, api::InitRobot{}});
    for (int i = 0; i < 3000; ++i) {
      journal.record({.connection = connection,
                      .wall = std::chrono::system_clock::now(),
                      .data = std::string(60'000, 'x')});
      if (i % 1000 != 0) continue;
      submit(simulation, api::RobotCommand{0, api::StopMotion{}});
      submit(simulation, api::SimulationCommand(api::StepBy{400}));
    }
    wait_for(simulation, 0, 1200);
    simulation.stop();
  }
  const auto all = records();
  std::uint64_t wires = 0, missing = 0, lost_commands = 0;
  for (const v1::JournalRecord& record : all) {
    wires += record.has_wire() ? 1 : 0;
    missing += record.gap().records();
    lost_commands += record.gap().commands();
  }
  EXPECT_GE(wires + missing, 3000U);  // events may be among what is missing
  EXPECT_GT(missing, 0U);
  EXPECT_EQ(lost_commands, 0U);
  const ReplayResult result = again(all);
  EXPECT_FALSE(result.difference) << result.difference->text;
  EXPECT_EQ(result.gaps, 0U);
  EXPECT_EQ(result.commands, 4U);
}

}  // namespace
}  // namespace aprsim::server::journal
