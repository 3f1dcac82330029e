// Scenes that change while the cell runs, and others that take their place: in saved states, in the
// journal and in the past.

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "proto/journal/journal_reader.hpp"
#include "tests/support/cell_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/past_client.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::test {
namespace {

ProcessResult ask(const DaemonProcess& daemon, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), std::string(APRSIM_BIN_DIR) + "/aprsim");
  arguments.insert(arguments.end(), {"--ports-file", daemon.ports_file()});
  return run_process(arguments);
}

void done(const DaemonProcess& daemon, const std::vector<std::string>& arguments) {
  const auto result = ask(daemon, arguments);
  EXPECT_EQ(result.exit_code, 0) << testing::PrintToString(arguments) << result.err;
}

ProcessResult run_again(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {std::string(APRSIM_BIN_DIR) + "/aprsim", "replay"});
  return run_process(arguments, std::chrono::seconds(300));
}

void expect_same(const std::vector<std::string>& arguments) {
  const auto again = run_again(arguments);
  EXPECT_EQ(again.exit_code, 0) << testing::PrintToString(arguments) << again.out << again.err;
  EXPECT_NE(again.out.find("all states are the same"), std::string::npos)
      << testing::PrintToString(arguments) << again.out;
}

const std::vector<std::vector<std::string>>& changes() {
  static const std::vector<std::vector<std::string>> all = {
      {"scene", "spawn", "sku_part_large_gear", "spare", "--at", "0.3", "-1", "1.2"},
      {"scene", "move", "spare", "--at", "0.3", "-1", "1.3"},
      {"scene", "set", "physics.friction.gear_tray", "0.2"},
      {"scene", "spawn", "sku_part_small_gear", "another", "--at", "0.4", "-0.9", "1.2"},
      {"scene", "remove", "spare"}};
  return all;
}

TEST(ChangedScene, GoesWithSavedStatesInFiles) {
  const TemporaryDirectory directory;
  const auto file = [&](std::size_t i) {
    return directory.path() + '/' + std::to_string(i) + ".state";
  };
  std::vector<std::pair<v1::Snapshot, v1::Snapshot>> seen;  // where it was saved, and later
  {
    DaemonProcess daemon({"--no-web", "--speed", "stepped"});
    CellClient cell(daemon.port("grpc"));
    for (std::size_t i = 0; i < changes().size(); ++i) {
      cell.step(40);
      done(daemon, changes()[i]);
      done(daemon, {"save", "s" + std::to_string(i), "--file", file(i)});
      const v1::Snapshot there = cell.snapshot();
      cell.step(300);
      seen.emplace_back(there, cell.snapshot());
    }
    // Each goes on in the same daemon, whatever the scene is now, and a reset undoes all.
    for (std::size_t i = 0; i < seen.size(); ++i) {
      done(daemon, {"load", "--file", file(i)});
      EXPECT_EQ(cell.snapshot().state_hash(), seen[i].first.state_hash()) << i;
      cell.step(300);
      EXPECT_EQ(cell.snapshot().state_hash(), seen[i].second.state_hash()) << i;
    }
    done(daemon, {"reset"});
    EXPECT_NE(cell.snapshot().bodies_size(), seen.back().first.bodies_size());
  }
  DaemonProcess daemon({"--no-web", "--speed", "stepped"});
  CellClient cell(daemon.port("grpc"));
  const int bodies = cell.snapshot().bodies_size();
  for (std::size_t i = seen.size(); i-- > 0;) {
    done(daemon, {"load", "--file", file(i)});
    EXPECT_EQ(cell.snapshot().bodies_size(), seen[i].first.bodies_size());
    EXPECT_EQ(cell.snapshot().state_hash(), seen[i].first.state_hash()) << i;
    cell.step(300);
    EXPECT_EQ(cell.snapshot().state_hash(), seen[i].second.state_hash()) << i;
    // A loaded state can be saved again.
    done(daemon, {"save", "again", "--file", directory.path() + "/again.state"});
  }
  done(daemon, {"reset"});
  EXPECT_EQ(cell.snapshot().bodies_size(), bodies);
}

TEST(ChangedScene, StatesGoWithTheSceneThatTheCellWasResetTo) {
  const TemporaryDirectory directory;
  const std::string before = directory.path() + "/before.state",
                    after = directory.path() + "/after.state";
  v1::Snapshot there, later;
  DaemonProcess daemon({"--no-web", "--speed", "stepped"});
  CellClient cell(daemon.port("grpc"));
  cell.step(20);
  done(daemon, {"save", "before", "--file", before});
  done(daemon, {"reset", "--scene", "aprs_2024"});
  cell.step(100);
  done(daemon, changes()[2]);
  done(daemon, {"save", "after", "--file", after});
  there = cell.snapshot();
  cell.step(300);
  later = cell.snapshot();
  const auto refused = ask(daemon, {"load", "--file", before});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("it is of scene 'aprs', and this cell is 'aprs_2024'"),
            std::string::npos)
      << refused.err;
  done(daemon, {"load", "--file", after});
  EXPECT_EQ(cell.snapshot().state_hash(), there.state_hash());
  // In the daemon's own memory it is there; a reset then goes back to its scene.
  done(daemon, {"load", "before"});
  EXPECT_EQ(cell.cell().scene(), "aprs");
  done(daemon, {"reset"});
  EXPECT_EQ(cell.cell().scene(), "aprs");
  done(daemon, {"load", "--file", before});

  DaemonProcess other({"--no-web", "--speed", "stepped", "--scene", "aprs_2024"});
  CellClient other_cell(other.port("grpc"));
  done(other, {"load", "--file", after});
  EXPECT_EQ(other_cell.snapshot().state_hash(), there.state_hash());
  other_cell.step(300);
  EXPECT_EQ(other_cell.snapshot().state_hash(), later.state_hash());
  EXPECT_EQ(ask(other, {"load", "--file", before}).exit_code, 1);
}

TEST(ChangedScene, AJournalWithoutNamesGivesItsFirstCheckpoint) {
  const TemporaryDirectory directory;
  const std::string file = directory.path() + "/run.journal";
  {
    DaemonProcess daemon({"--no-web", "--speed", "stepped", "--journal", file});
    CellClient(daemon.port("grpc")).step(1300);
    EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  }
  // Steps after the last compared state are run again, too.
  EXPECT_NE(run_again({file}).out.find(": 1300 steps"), std::string::npos);
  DaemonProcess daemon({"--no-web", "--speed", "stepped"});
  const auto loaded = ask(daemon, {"load", "--file", file});
  EXPECT_EQ(loaded.exit_code, 0) << loaded.err;
  EXPECT_NE(loaded.out.find("loaded 'aprs-step0'"), std::string::npos) << loaded.out;
}

/// A run of two scenes with changes of each.
class ChangedRun : public testing::Test {
 protected:
  void SetUp() override {
    DaemonProcess daemon({"--no-web", "--speed", "stepped", "--journal", journal_});
    CellClient cell(daemon.port("grpc"));
    PastClient past(daemon);
    const auto see = [&] {
      const v1::Snapshot now = cell.snapshot();
      seen_[{now.epoch(), now.step()}] = now.state_hash();
    };
    const auto steps = [&](std::uint64_t count) {
      for (; count > 0; count -= 3000) {
        cell.step(3000);
        see();
      }
    };
    done(daemon, {"conveyor", "set", "--speed", "40%"});
    steps(3000);
    done(daemon, changes()[0]);
    steps(9000);  // a checkpoint with the spare part
    done(daemon, changes()[2]);
    steps(9000);  // and one with the other friction
    done(daemon, {"reset", "--scene", "aprs_2024"});
    done(daemon, {"conveyor", "set", "--speed", "20%"});
    steps(12'000);
    done(daemon, changes()[3]);
    steps(9000);
    done(daemon, {"reset"});
    steps(12'000);
    for (const auto& [moment, hash] : seen_) {
      EXPECT_EQ(past.at(moment.first, moment.second).state_hash(), hash)
          << moment.first << ':' << moment.second;
    }
    done(daemon, {"incident", "--last", "5s", "--file", incident_});
    done(daemon, {"incident", "--last", "21s", "--file", long_incident_});
    EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  }

  void expect_the_same_from_every_checkpoint();
  void expect_what_was_there_in_exports();
  void expect_all_of_its_past_served();

  TemporaryDirectory directory_;
  std::string journal_ = directory_.path() + "/run.journal";
  std::string incident_ = directory_.path() + "/incident.journal";
  std::string long_incident_ = directory_.path() + "/long.journal";
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::uint64_t> seen_;
};

void ChangedRun::expect_the_same_from_every_checkpoint() {
  expect_same({journal_});
  auto reader = journal::JournalReader::open(journal_);
  ASSERT_TRUE(reader);
  int checkpoints = 0, with_scene = 0, with_changes = 0;
  for (v1::JournalRecord record; reader->next(record);) {
    if (!record.has_checkpoint()) continue;
    const auto& checkpoint = record.checkpoint();
    ++checkpoints;
    with_scene += checkpoint.has_scene() ? 1 : 0;
    with_changes += checkpoint.has_changed_scene() ? 1 : 0;
    expect_same({journal_, "--from",
                 std::to_string(checkpoint.time().epoch()) + ':' +
                     std::to_string(static_cast<double>(checkpoint.time().step()) * 1e-3)});
  }
  EXPECT_EQ(checkpoints, 8);
  EXPECT_EQ(with_scene, 5);
  EXPECT_EQ(with_changes, 3);
  expect_same({incident_});
  expect_same({long_incident_});
}

void ChangedRun::expect_what_was_there_in_exports() {
  const std::string tables = directory_.path() + "/tables", mcap = directory_.path() + "/run.mcap";
  const auto exported = run_process({std::string(APRSIM_BIN_DIR) + "/aprsim", "trace", "export",
                                     journal_, "--csv", tables, "--mcap", mcap, "--rate", "2"},
                                    std::chrono::seconds(300));
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  std::ifstream in(tables + "/bodies.csv");
  std::map<std::string, int> rows;
  for (std::string line; std::getline(in, line);) {
    const auto begin = line.find(',') + 1;
    ++rows[line.substr(begin, line.find(',', begin) - begin)];
  }
  EXPECT_GT(rows["spare"], 30);
  EXPECT_LT(rows["spare"], 40);
  EXPECT_GT(rows["another"], 10);
  std::ifstream bytes(mcap, std::ios::binary);
  const std::string content(std::istreambuf_iterator<char>(bytes), {});
  EXPECT_NE(content.find("MCAP"), std::string::npos);
}

void ChangedRun::expect_all_of_its_past_served() {
  DaemonProcess daemon({"--replay", journal_, "--serve", "--speed", "max", "--no-web"});
  CellClient cell(daemon.port("grpc"));
  PastClient past(daemon);
  cell.wait_for([](const auto& s) { return s.epoch() == 2 && s.step() == 12'000; }, "its end",
                std::chrono::seconds(60));
  EXPECT_EQ(cell.cell().scene(), "aprs_2024");
  // To and fro between the scenes.
  auto forwards = seen_.begin();
  auto backwards = seen_.rbegin();
  for (std::size_t i = 0; i < seen_.size() / 2; ++i, ++forwards, ++backwards) {
    for (const auto& [moment, hash] : {*forwards, *backwards}) {
      EXPECT_EQ(past.at(moment.first, moment.second).state_hash(), hash)
          << moment.first << ':' << moment.second;
    }
  }
}

// One run, which takes a while to be recorded.
TEST_F(ChangedRun, IsTheSameFromEveryCheckpointExportedAndServed) {
  expect_the_same_from_every_checkpoint();
  expect_what_was_there_in_exports();
  expect_all_of_its_past_served();
}

}  // namespace
}  // namespace aprsim::test
