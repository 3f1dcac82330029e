// Real child processes, told by a shell what to do.
#include "server/programs/programs.hpp"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/eventually.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::server {
namespace {

using namespace std::chrono_literals;
using test::eventually;

Program shell(const std::string& name, const std::string& script) {
  // The argument after the script is $0; a seed option and its value are $1 and $2.
  return {{name, "says what it is told"}, {"/bin/sh", "-c", script, "sh"}, "--seed"};
}

class ProgramsTest : public ::testing::Test {
 protected:
  Programs& with(std::vector<Program> all) {
    ProgramsOptions options;
    options.programs = std::move(all);
    options.environment["APRSIM_TEST_WORD"] = "from the daemon";
    options.patience = patience;
    options.last_patience = 200ms;
    programs = std::make_unique<Programs>(std::move(options));
    return *programs;
  }
  [[nodiscard]] bool says(const std::string& line) const {
    const auto status = programs->status();
    return std::ranges::find(status->lines, line) != status->lines.end();
  }
  [[nodiscard]] bool ended() const {
    return eventually([&] { return !programs->status()->running; });
  }

  std::chrono::milliseconds patience = 20s;
  std::unique_ptr<Programs> programs;
};

TEST_F(ProgramsTest, OneRunsToItsEndAndItsProgressIsTold) {
  with({shell("job", R"(echo "{\"progress\": {\"placed\": 2}}"; echo "$APRSIM_TEST_WORD, $1 $2";
                        echo oops >&2; printf 'no line end')")});
  EXPECT_EQ(programs->status()->name, "");
  ASSERT_EQ(programs->status()->offers.size(), 1U);
  ASSERT_TRUE(programs->start("job", 7));
  EXPECT_TRUE(programs->status()->running);
  ASSERT_TRUE(ended());
  const auto status = programs->status();
  EXPECT_EQ(status->name, "job");
  EXPECT_EQ(status->placed, 2U);
  EXPECT_EQ(status->end_reason, "done");
  EXPECT_FALSE(status->failed);
  EXPECT_EQ(status->lines,
            (std::vector<std::string>{"from the daemon, --seed 7", "oops", "no line end"}));
}

TEST_F(ProgramsTest, OneDiesAndTheNextRuns) {
  with({shell("dies", "echo 'no cell' >&2; exit 3"), shell("well", "true"),
        shell("struck", "kill -SEGV $$")});
  ASSERT_TRUE(programs->start("dies", {}));
  ASSERT_TRUE(ended());
  EXPECT_TRUE(programs->status()->failed);
  EXPECT_EQ(programs->status()->end_reason, "ended with 3");
  EXPECT_TRUE(says("no cell"));
  ASSERT_TRUE(programs->start("struck", {})) << "who is told of the end can start the next";
  ASSERT_TRUE(ended());
  EXPECT_EQ(programs->status()->end_reason, "ended by signal 11");
  ASSERT_TRUE(programs->start("well", {}));
  ASSERT_TRUE(ended());
  EXPECT_FALSE(programs->status()->failed);
  EXPECT_TRUE(programs->status()->lines.empty()) << "of the one before";
}

TEST_F(ProgramsTest, OneThatCannotBeStartedIsTold) {
  with({{{"gone", ""}, {"/no/such/program"}, ""}});
  ASSERT_TRUE(programs->start("gone", {}));
  ASSERT_TRUE(ended());
  EXPECT_TRUE(programs->status()->failed);
  EXPECT_EQ(programs->status()->end_reason,
            "cannot start /no/such/program: No such file or directory");
}

TEST_F(ProgramsTest, RefusesWhatCannotBe) {
  with({shell("waits", "echo here; exec sleep 1000"), {{"plain", ""}, {"/bin/true"}, ""}});
  EXPECT_EQ(programs->start("rm -rf", {}).error().message,
            "'rm -rf' is not a program that can be started here");
  EXPECT_EQ(programs->start("plain", 3).error().field, "seed");
  EXPECT_EQ(programs->stop().error().message, "no program runs");
  ASSERT_TRUE(programs->start("waits", {}));
  EXPECT_EQ(programs->start("plain", {}).error().message, "waits runs; stop it first");
  ASSERT_TRUE(eventually([&] { return says("here"); }));
  ASSERT_TRUE(programs->stop());
  ASSERT_TRUE(ended());
  EXPECT_EQ(programs->status()->end_reason, "stopped");
  EXPECT_FALSE(programs->status()->failed);
}

TEST_F(ProgramsTest, AScenarioOfAPageRunsFromAFileThatGoesWithIt) {
  const test::TemporaryDirectory directory;
  ProgramsOptions options;
  options.programs = {shell("job", "true")};
  options.scenario_command = {"/bin/sh", "-c", R"(cat "$1"; echo "$2 $3"; echo "$1")", "sh"};
  options.directory = directory.path();
  programs = std::make_unique<Programs>(std::move(options));
  ASSERT_TRUE(programs->start_scenario("mine", "description: this one\n", 6));
  EXPECT_EQ(programs->status()->name, "mine");
  EXPECT_EQ(programs->start_scenario("other", "", {}).error().message, "mine runs; stop it first");
  ASSERT_TRUE(ended());
  EXPECT_EQ(programs->status()->lines,
            (std::vector<std::string>{"description: this one", "--seed 6",
                                      std::string(directory.path()) + "/mine.yaml"}));
  EXPECT_TRUE(std::filesystem::is_empty(directory.path()));
  ASSERT_TRUE(programs->start("job", {}));
  ASSERT_TRUE(ended());
}

TEST_F(ProgramsTest, AScenarioOfAPageRunsOnlyWhereProgramsDo) {
  with({shell("job", "true")});
  EXPECT_EQ(programs->start_scenario("mine", "", {}).error().message,
            "No scenario can be run here.");
  ProgramsOptions options;
  options.scenario_command = {"/bin/true"};
  options.refusal = "not from here";
  programs = std::make_unique<Programs>(std::move(options));
  EXPECT_EQ(programs->start_scenario("mine", "", {}).error().message, "not from here");
}

TEST_F(ProgramsTest, PagesNeitherStartNorStopWhereTheyMayNot) {
  ProgramsOptions options;
  options.programs = {shell("waits", "exec sleep 1000")};
  options.refusal = "not from here";
  programs = std::make_unique<Programs>(std::move(options));
  EXPECT_EQ(programs->status()->refusal, "not from here");
  EXPECT_EQ(programs->start("waits", {}).error().message, "not from here");
  ASSERT_TRUE(programs->launch("waits", {}));
  EXPECT_EQ(programs->stop().error().message, "not from here");
  EXPECT_TRUE(programs->status()->running);
  EXPECT_EQ(programs->status()->refusal, "not from here");
}

TEST_F(ProgramsTest, OneThatDoesNotEndIsKilledWithItsChildren) {
  patience = 200ms;
  // The inner one tells its number, so that its end can be seen.
  with({shell("stubborn", "trap '' TERM; sleep 1000 & echo \"pid $!\"; wait; wait")});
  ASSERT_TRUE(programs->start("stubborn", {}));
  ASSERT_TRUE(eventually([&] { return !programs->status()->lines.empty(); }));
  const pid_t inner = std::stoi(programs->status()->lines[0].substr(4));
  ASSERT_TRUE(programs->stop());
  ASSERT_TRUE(ended());
  EXPECT_TRUE(programs->status()->failed);
  EXPECT_EQ(programs->status()->end_reason, "killed: it did not end on SIGTERM");
  // Nobody here waits for the inner one; it is gone, or a corpse without a command line.
  EXPECT_TRUE(eventually([&] {
    std::ifstream command("/proc/" + std::to_string(inner) + "/cmdline");
    return command.peek() == std::ifstream::traits_type::eof();
  }));
}

TEST_F(ProgramsTest, AFloodIsHeldBackAndHarmsNothing) {
  with({shell("floods", "yes '{\"event\": \"more\"}'"), shell("shouts", "yes 'not even JSON'")});
  for (const char* name : {"floods", "shouts"}) {
    ASSERT_TRUE(programs->start(name, {}));
    ASSERT_TRUE(eventually([&] { return programs->status()->lines.size() == 100; }));
    ASSERT_TRUE(programs->stop());
    ASSERT_TRUE(ended()) << name;
    EXPECT_EQ(programs->status()->lines.size(), 100U);
  }
}

TEST_F(ProgramsTest, EndsWithUs) {
  with({shell("stubborn", "trap '' TERM; echo \"pid $$\"; while :; do sleep 1000; done")});
  ASSERT_TRUE(programs->start("stubborn", {}));
  ASSERT_TRUE(eventually([&] { return !programs->status()->lines.empty(); }));
  const pid_t child = std::stoi(programs->status()->lines[0].substr(4));
  EXPECT_EQ(kill(child, 0), 0);
  programs->close();
  EXPECT_EQ(programs->start("stubborn", {}).error().code, ErrorCode::kUnavailable);
  programs.reset();
  EXPECT_EQ(kill(child, 0), -1) << "it has been waited for";
}

TEST_F(ProgramsTest, GivesItsFilesToNobody) {
  const test::TemporaryDirectory directory;
  std::ofstream open(directory.path() + "/open");
  with({shell("lists", "for f in /proc/self/fd/*; do readlink $f; done")});
  ASSERT_TRUE(programs->start("lists", {}));
  ASSERT_TRUE(ended());
  const auto lines = programs->status()->lines;
  ASSERT_FALSE(lines.empty());
  for (const std::string& line : lines) {
    EXPECT_EQ(line.find(directory.path()), std::string::npos) << line;
    EXPECT_EQ(line.find("socket:"), std::string::npos) << line;
  }
}

TEST_F(ProgramsTest, OthersAreOfferedWhileOneRuns) {
  with({shell("first", "echo begun; exec sleep 600")});
  ASSERT_TRUE(programs->start("first", {}));
  ASSERT_TRUE(eventually([&] { return says("begun"); }));
  programs->offer({shell("second", "true")});
  ASSERT_EQ(programs->status()->offers.size(), 1U);
  EXPECT_EQ(programs->status()->offers[0].name, "second");
  EXPECT_TRUE(programs->status()->running);
  ASSERT_TRUE(programs->stop());
  ASSERT_TRUE(ended());
  // The end of a program does not bring its offer back.
  ASSERT_EQ(programs->status()->offers.size(), 1U);
  EXPECT_EQ(programs->status()->offers[0].name, "second");
  EXPECT_FALSE(programs->start("first", {}));
  EXPECT_TRUE(programs->start("second", {}));
  ASSERT_TRUE(ended());
  programs->offer({});
  EXPECT_EQ(programs->status()->refusal, "No program is known for this scene.");
}

TEST(KnownPrograms, AreThoseOfTheScene) {
  const auto names = [](const std::string& scene) {
    std::vector<std::string> out;
    for (const Program& program : known_programs(scene, "127.0.0.1", "/tmp/ports")) {
      out.push_back(program.offer.name);
    }
    return out;
  };
  const auto has = [](const std::vector<std::string>& all, const char* name) {
    return std::ranges::find(all, name) != all.end();
  };
  const auto aprs = names("aprs"), newer = names("aprs_2024");
  EXPECT_EQ(aprs.front(), "demo");
  EXPECT_TRUE(has(aprs, "clean_2017"));
  EXPECT_FALSE(has(aprs, "clean_2024")) << "of another scene";
  EXPECT_FALSE(has(aprs, "insufficient_parts")) << "it takes parts out";
  EXPECT_TRUE(has(newer, "demo"));
  EXPECT_TRUE(has(newer, "clean_2024"));
  EXPECT_TRUE(names("empty_belt").empty());
}

}  // namespace
}  // namespace aprsim::server
