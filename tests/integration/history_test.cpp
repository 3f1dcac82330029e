// The past of a running daemon, states that go from one daemon to another in files, and recorded
// runs that are watched.

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/past_client.hpp"
#include "tests/support/tcp_socket.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::test {
namespace {

std::string swing(double degrees) {
  return "<ActuateJoint><JointNumber>1</JointNumber><JointPosition>" + std::to_string(degrees) +
         "</JointPosition><JointDetails xsi:type=\"JointSpeedAccelType\"/></ActuateJoint>";
}

/// Sends a command to a cell that stands, and waits until it has taken effect.
void command(CellClient& cell, CrclTextClient& robot, const std::string& type,
             const std::string& fields = "") {
  const std::uint64_t before = cell.snapshot().applied_ticket();
  robot.send(type, fields);
  cell.wait_for([&](const auto& s) { return s.applied_ticket() > before; }, type);
}

ProcessResult aprsim(const std::vector<std::string>& arguments) {
  std::vector<std::string> argv = {std::string(APRSIM_BIN_DIR) + "/aprsim"};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  return run_process(argv, std::chrono::seconds(120));
}

ProcessResult aprsim(const DaemonProcess& daemon, std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--ports-file", daemon.ports_file()});
  return aprsim(arguments);
}

TEST(History, HasEveryMomentAsItWasLive) {
  DaemonProcess daemon({"--no-web", "--speed", "2"});
  CellClient cell(daemon.port("grpc"));
  PastClient past(daemon);
  CrclTextClient fanuc(daemon.port("crcl.fanuc"));
  fanuc.send("InitCanonType");
  fanuc.send("ActuateJointsType", swing(50));
  std::map<std::uint64_t, v1::Snapshot> live;
  for (int i = 0; i < 40; ++i) {
    const std::uint64_t last = live.empty() ? 0 : live.rbegin()->first;
    const auto now = cell.wait_for([&](const auto& s) { return s.step() > last + 50; }, "a step");
    live[now.step()] = now;
  }
  EXPECT_NE(live.begin()->second.state_hash(), live.rbegin()->second.state_hash());
  for (auto it = live.rbegin(); it != live.rend(); ++it) {
    const auto then = past.at(0, it->first);
    ASSERT_TRUE(past.status.ok()) << past.status.error_message();
    EXPECT_EQ(then.state_hash(), it->second.state_hash()) << "step " << it->first;
    EXPECT_EQ(then.robots(0).joints(0).position_rad(),
              it->second.robots(0).joints(0).position_rad());
    EXPECT_EQ(then.contact_count(), it->second.contact_count());
    EXPECT_EQ(then.robots(0).action().SerializeAsString(),
              it->second.robots(0).action().SerializeAsString());
  }
  const auto spans = past.history();
  ASSERT_EQ(spans.spans_size(), 1);
  EXPECT_EQ(spans.spans(0).first_step(), 0U);
  EXPECT_GE(spans.spans(0).last_step(), live.rbegin()->first);

  const auto range = past.range(100, 1100, 100);
  ASSERT_EQ(range.size(), 11U) << past.status.error_message();
  EXPECT_EQ(range.front().step(), 100U);
  EXPECT_EQ(range.back().step(), 1100U);

  (void)past.at(0, 1'000'000'000);
  EXPECT_EQ(past.status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_NE(past.status.error_message().find("step 1000000000 of epoch 0"), std::string::npos);
  (void)past.range(100, 50, 1);
  EXPECT_EQ(past.status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST(History, HasABookmarkWhereAListenerRefusedSomething) {
  DaemonProcess daemon({"--no-web", "--speed", "stepped"});
  CellClient cell(daemon.port("grpc"));
  PastClient past(daemon);
  cell.step(500);
  CrclTextClient fanuc(daemon.port("crcl.fanuc"));
  fanuc.send("ActuateJointsType", swing(30));
  EXPECT_EQ(CrclTextClient::field(fanuc.status(), "CommandState"), "CRCL_Error");
  TcpSocket belt(daemon.port("modbus"));
  // No register is there.
  ASSERT_TRUE(belt.send(std::string("\0\1\0\0\0\6\1\6\xEE\0\0\1", 12)));
  EXPECT_EQ(belt.receive(TcpSocket::Clock::now() + std::chrono::seconds(30)).at(7), '\x86');
  const auto all = past.bookmarks();
  const auto count = [&](const std::string& listener, const std::string& why) {
    return std::ranges::count_if(all, [&](const v1::Bookmark& mark) {
      return mark.kind() == v1::BOOKMARK_KIND_REFUSAL && mark.moment().step() == 500 &&
             mark.text().starts_with(listener + ": refused: ") &&
             mark.text().find(why) != std::string::npos;
    });
  };
  EXPECT_EQ(count("crcl.fanuc", "Not initialized"), 1);
  EXPECT_EQ(count("modbus", "exception 2"), 1);
  // A client that insists does not push the others out.
  for (int i = 0; i < 500; ++i) {
    ASSERT_TRUE(belt.send(std::string("\0\1\0\0\0\6\1\6\xEE\0\0\1", 12)));
    (void)belt.receive(TcpSocket::Clock::now() + std::chrono::seconds(30));
  }
  EXPECT_LT(past.bookmarks().size(), 100U);
}

TEST(History, KeepsBookmarksAndPutsTheCellBack) {
  DaemonProcess daemon({"--no-web", "--speed", "stepped"});
  CellClient cell(daemon.port("grpc"));
  PastClient past(daemon);
  CrclTextClient fanuc(daemon.port("crcl.fanuc"));
  cell.step(500);
  command(cell, fanuc, "InitCanonType");
  command(cell, fanuc, "ActuateJointsType", swing(30));
  cell.step(700);
  const auto there = cell.snapshot();
  cell.step(800);
  const auto own = past.add_bookmark(900, "look here");
  ASSERT_TRUE(past.status.ok()) << past.status.error_message();
  const auto all = past.bookmarks();
  ASSERT_GE(all.size(), 3U);
  EXPECT_EQ(all.back().text(), "look here");
  EXPECT_EQ(all.back().kind(), v1::BOOKMARK_KIND_OWN);
  EXPECT_EQ(all.front().kind(), v1::BOOKMARK_KIND_COMMAND);
  EXPECT_EQ(all.front().moment().step(), 500U);
  past.remove_bookmark(own.id());
  EXPECT_TRUE(past.status.ok());
  past.remove_bookmark(own.id());
  EXPECT_EQ(past.status.error_code(), grpc::StatusCode::NOT_FOUND);

  const auto receipt = past.resume_from(there.step());
  ASSERT_TRUE(past.status.ok()) << past.status.error_message();
  EXPECT_EQ(receipt.epoch(), 1U);
  EXPECT_EQ(receipt.step(), there.step());
  EXPECT_EQ(cell.snapshot().state_hash(), there.state_hash());
  cell.step(800);
  // As it went on then.
  EXPECT_EQ(cell.snapshot().state_hash(), past.at(0, there.step() + 800).state_hash());
  EXPECT_EQ(past.history().spans_size(), 2);
  EXPECT_EQ(past.history().spans(1).loaded_state(), "1.200 s of run 0");
}

TEST(History, IsNotKeptWhereItIsSwitchedOff) {
  DaemonProcess daemon({"--no-web", "--set", "history.minutes=0"});
  PastClient past(daemon);
  (void)past.history();
  EXPECT_EQ(past.status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_NE(past.status.error_message().find("history.minutes"), std::string::npos);
}

TEST(StateFiles, GoFromOneDaemonToAnother) {
  const TemporaryDirectory directory;
  const std::string file = directory.path() + "/there.state";
  v1::Snapshot there, later;
  {
    DaemonProcess daemon({"--no-web", "--speed", "stepped"});
    CellClient cell(daemon.port("grpc"));
    CrclTextClient fanuc(daemon.port("crcl.fanuc"));
    command(cell, fanuc, "InitCanonType");
    command(cell, fanuc, "ActuateJointsType", swing(30));
    cell.step(600);
    const auto saved = aprsim(daemon, {"save", "there", "--file", file});
    ASSERT_EQ(saved.exit_code, 0) << saved.err;
    there = cell.snapshot();
    cell.step(500);
    later = cell.snapshot();
  }
  {
    DaemonProcess daemon({"--no-web", "--speed", "stepped", "--seed", "9"});
    CellClient cell(daemon.port("grpc"));
    const auto loaded = aprsim(daemon, {"load", "--file", file});
    ASSERT_EQ(loaded.exit_code, 0) << loaded.err;
    EXPECT_NE(loaded.out.find("loaded 'there'"), std::string::npos) << loaded.out;
    EXPECT_EQ(cell.snapshot().state_hash(), there.state_hash());
    EXPECT_EQ(cell.snapshot().step(), there.step());
    cell.step(500);
    // The motion under way went on as it did there.
    EXPECT_EQ(cell.snapshot().state_hash(), later.state_hash());
    const auto named = aprsim(daemon, {"load", "other", "--file", file});
    EXPECT_EQ(named.exit_code, 0) << named.err;
    EXPECT_NE(aprsim(daemon, {"states", "list"}).out.find("other"), std::string::npos);

    std::ifstream in(file, std::ios::binary);
    std::string bytes(std::istreambuf_iterator<char>(in), {});
    const std::string whole = bytes;
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    for (const std::string& wrong : {bytes, whole.substr(0, whole.size() / 2), std::string(),
                                     std::string("no state at all")}) {
      const std::string broken = directory.write("broken.state", wrong);
      const auto refused = aprsim(daemon, {"load", "--file", broken});
      EXPECT_EQ(refused.exit_code, 1) << refused.out;
      EXPECT_NE(refused.err.find(broken), std::string::npos) << refused.err;
    }
  }
  DaemonProcess daemon({"--no-web", "--scene", "empty_belt"});
  const auto refused = aprsim(daemon, {"load", "--file", file});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("it is of scene 'aprs', and this cell is 'empty_belt'"),
            std::string::npos)
      << refused.err;
}

TEST(StateFiles, OfAnotherUserAreLoadedOnlyWhereThatIsAllowed) {
  const TemporaryDirectory directory, other;
  const std::string file = directory.path() + "/there.state";
  ASSERT_EQ(setenv("STATE_DIRECTORY", directory.path().c_str(), 1), 0);
  {
    DaemonProcess daemon({"--no-web", "--speed", "stepped"});
    const auto saved = aprsim(daemon, {"save", "there", "--file", file});
    ASSERT_EQ(saved.exit_code, 0) << saved.err;
  }
  ASSERT_EQ(setenv("STATE_DIRECTORY", other.path().c_str(), 1), 0);
  {
    DaemonProcess daemon({"--no-web", "--speed", "stepped"});
    const auto refused = aprsim(daemon, {"load", "--file", file});
    EXPECT_EQ(refused.exit_code, 1) << refused.out;
    EXPECT_NE(refused.err.find("--allow-foreign-states"), std::string::npos) << refused.err;
  }
  {
    DaemonProcess daemon({"--no-web", "--speed", "stepped", "--allow-foreign-states"});
    const auto loaded = aprsim(daemon, {"load", "--file", file});
    EXPECT_EQ(loaded.exit_code, 0) << loaded.err;
  }
  unsetenv("STATE_DIRECTORY");
}

class RecordedRun : public testing::Test {
 protected:
  void SetUp() override {
    DaemonProcess daemon({"--no-web", "--speed", "stepped", "--journal", file_});
    CellClient cell(daemon.port("grpc"));
    CrclTextClient fanuc(daemon.port("crcl.fanuc"));
    command(cell, fanuc, "InitCanonType");
    for (int i = 0; i < 10; ++i) {
      command(cell, fanuc, "ActuateJointsType", swing(i % 2 == 0 ? 20 : -20));
      cell.step(2500);
      if (i == 4) middle_ = cell.snapshot();
    }
    last_ = cell.snapshot();
    // No register is there, and nothing goes backwards.
    TcpSocket belt(daemon.port("modbus"));
    ASSERT_TRUE(belt.send(std::string("\0\1\0\0\0\6\1\6\xEE\0\0\1", 12)));
    EXPECT_EQ(belt.receive(TcpSocket::Clock::now() + std::chrono::seconds(30)).at(7), '\x86');
    grpc::ClientContext context;
    v1::SetSpeedRequest backwards;
    v1::SetSpeedResponse response;
    backwards.set_factor(-1);
    EXPECT_EQ(cell.control->SetSpeed(&context, backwards, &response).error_code(),
              grpc::StatusCode::INVALID_ARGUMENT);
    EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  }

  TemporaryDirectory directory_;
  std::string file_ = directory_.path() + "/run.journal";
  v1::Snapshot middle_, last_;
};

TEST_F(RecordedRun, IsTheSameFromEveryCheckpointAndToAnyTime) {
  auto again = aprsim({"replay", file_});
  EXPECT_EQ(again.exit_code, 0) << again.out << again.err;
  EXPECT_NE(again.out.find("25000 steps"), std::string::npos) << again.out;
  for (const auto& [from, steps] : std::map<std::string, std::string>{{"0", "25000 steps"},
                                                                      {"9.999", "25000 steps"},
                                                                      {"10", "15000 steps"},
                                                                      {"0:13", "15000 steps"},
                                                                      {"20.5", "5000 steps"}}) {
    again = aprsim({"replay", file_, "--from", from});
    EXPECT_EQ(again.exit_code, 0) << again.out << again.err;
    EXPECT_NE(again.out.find(steps), std::string::npos) << from << ": " << again.out;
    EXPECT_NE(again.out.find("all states are the same"), std::string::npos) << again.out;
  }
  again = aprsim({"replay", file_, "--from", "11", "--to", "12.5", "--json"});
  EXPECT_EQ(again.exit_code, 0) << again.out << again.err;
  EXPECT_NE(again.out.find("\"steps\":2500,"), std::string::npos) << again.out;
  EXPECT_NE(again.out.find("\"same\":true"), std::string::npos) << again.out;
  again = aprsim({"replay", file_, "--from", "3:1"});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_NE(again.err.find("epoch 3 is not recorded"), std::string::npos) << again.err;
}

TEST_F(RecordedRun, IsWatchedWithItsWholePastAndTakesNoCommands) {
  DaemonProcess daemon({"--replay", file_, "--serve", "--speed", "max"});
  EXPECT_EQ(daemon.ports().size(), 2U) << "grpc and web alone";
  CellClient cell(daemon.port("grpc"));
  PastClient past(daemon);
  EXPECT_EQ(past.history().spans(0).last_step(), 25'000U);
  EXPECT_EQ(past.at(0, middle_.step()).state_hash(), middle_.state_hash());
  const auto last = cell.wait_for([](const auto& s) { return s.step() == 25'000; }, "its end",
                                  std::chrono::seconds(60));
  EXPECT_EQ(last.state_hash(), last_.state_hash());
  // Past events are reported unchanged, and marked on the line.
  const auto marks = past.bookmarks();
  EXPECT_GE(std::ranges::count(marks, v1::BOOKMARK_KIND_COMMAND, &v1::Bookmark::kind), 11);
  const auto events = aprsim(daemon, {"events", "--past", "--kind", "command-begun"});
  EXPECT_GE(std::ranges::count(events.out, '\n'), 11) << events.out << events.err;
  for (const std::string listener : {"modbus", "grpc"}) {
    EXPECT_EQ(std::ranges::count_if(marks,
                                    [&](const v1::Bookmark& mark) {
                                      return mark.kind() == v1::BOOKMARK_KIND_REFUSAL &&
                                             mark.moment().step() == 25'000 &&
                                             mark.text().starts_with(listener + ": refused: ");
                                    }),
              1)
        << listener;
  }
  const auto refusals = aprsim(daemon, {"events", "--past", "--kind", "refused"});
  EXPECT_NE(refusals.out.find("exception 2"), std::string::npos) << refusals.out << refusals.err;
  grpc::ClientContext context;
  v1::ResetResponse response;
  const auto refused = cell.control->Reset(&context, {}, &response);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_NE(refused.error_message().find("accepts no commands"), std::string::npos)
      << refused.error_message();
  (void)past.resume_from(1000);
  EXPECT_EQ(past.status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
}

TEST_F(RecordedRun, ThatIsDamagedInTheMiddleSaysSo) {
  std::ifstream in(file_, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(in), {});
  const std::string cut = directory_.write("cut.journal", bytes.substr(0, bytes.size() * 2 / 3));
  const auto again = aprsim({"replay", cut});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.out.find("ends early"), std::string::npos) << again.out;
}

}  // namespace
}  // namespace aprsim::test
