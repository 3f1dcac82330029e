// Runs over sockets, run again: what the listeners answered is compared, too.

#include <csignal>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "proto/journal/frames.hpp"
#include "proto/journal/journal_reader.hpp"
#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/tcp_socket.hpp"
#include "tests/support/temporary_directory.hpp"
#include "tests/support/vision_client.hpp"

namespace aprsim::test {
namespace {

using Change = std::function<bool(v1::JournalWire&)>;

std::string word(int value) {
  return {static_cast<char>(value >> 8), static_cast<char>(value & 0xFF)};
}

/// A Modbus client that has always the same transaction.
class Belt {
 public:
  explicit Belt(std::uint16_t port) : socket_(port) {}

  void write(int address, int value) { ask("\6" + word(address) + word(value), 12); }
  void read_inputs(int address, int count) {
    ask("\4" + word(address) + word(count), static_cast<std::size_t>(9 + 2 * count));
  }

 private:
  void ask(const std::string& unit, std::size_t answer) {
    ASSERT_TRUE(socket_.send(std::string("\0\1\0\0\0\6\1", 7) + unit));
    const auto deadline = TcpSocket::Clock::now() + std::chrono::seconds(30);
    for (std::size_t got = 0; got < answer;) got += socket_.receive(deadline).size();
  }

  TcpSocket socket_;
};

/// A run of all wires at twice real time; files of it that were changed.
class ReplayOfWires : public testing::Test {
 protected:
  void SetUp() override {
    const std::string scene = directory_.write("mapped.yaml",
                                               "base: aprs\n"
                                               "modbus_servers:\n"
                                               "  - name: line\n"
                                               "    registers:\n"
                                               "      - {area: coil, address: 0, signal: belt.run,"
                                               " access: write}\n"
                                               "      - {area: input, address: 7, signal:"
                                               " belt.travel_m, encoding: int32, scale: 0.0001}\n"
                                               "      - {area: input, address: 9, signal:"
                                               " cell.time_s, encoding: float32}\n");
    DaemonProcess daemon({"--no-web", "--scene", scene, "--speed", "2", "--journal", file_, "--set",
                          "modbus.full_scale_m_s=0.4"});
    CellClient cell(daemon.port("grpc"));
    CrclTextClient fanuc(daemon.port("crcl.fanuc")), motoman(daemon.port("crcl.motoman"));
    VisionClient camera(daemon.port("vision.fanuc"));
    Belt belt(daemon.port("modbus")), line(daemon.port("modbus.line"));
    fanuc.send("InitCanonType");
    motoman.send("InitCanonType");
    fanuc.send("EnableGripperType", "<GripperName>fanuc_gripper</GripperName>");
    motoman.send("SetLengthUnitsType", "<UnitName>inch</UnitName>");
    motoman.send("SetAngleUnitsType", "<UnitName>radian</UnitName>");
    belt.write(0x8002, 10'000);
    belt.write(0x8000, 1);
    const std::uint64_t begin = cell.snapshot().step();
    for (double degrees = 15; cell.snapshot().step() < begin + 12'000; degrees = -degrees) {
      for (CrclTextClient* robot : {&fanuc, &motoman}) {
        robot->send("ActuateJointsType",
                    "<ActuateJoint><JointNumber>1</JointNumber><JointPosition>" +
                        std::to_string(degrees) +
                        "</JointPosition><JointDetails "
                        "xsi:type=\"JointSpeedAccelType\"/></ActuateJoint>");
        for (int i = 0; i < 20; ++i) robot->status();
      }
      fanuc.send("SetEndEffectorType",
                 degrees > 0 ? "<Setting>1</Setting>" : "<Setting>0</Setting>");
      belt.read_inputs(0x8000, 16);
      line.read_inputs(7, 4);
      camera.take();
    }
    EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  }

  /// The findings of a replay.
  [[nodiscard]] nlohmann::json replayed(const std::string& file,
                                        const std::vector<std::string>& options = {}) const {
    std::vector<std::string> line{std::string(APRSIM_BIN_DIR) + "/aprsimd", "--replay", file,
                                  "--json"};
    line.insert(line.end(), options.begin(), options.end());
    const auto again = run_process(line, std::chrono::seconds(600));
    EXPECT_NE(again.exit_code, 2) << again.err;
    auto found = nlohmann::json::parse(again.out);
    EXPECT_EQ(again.exit_code, found["same"] == true ? 0 : 1) << again.out;
    return found;
  }

  /// A copy of the run whose first record of a wire that `change` takes is another one.
  [[nodiscard]] std::string changed(const Change& change) const {
    auto reader = journal::JournalReader::open(file_);
    journal::FrameEncoder encoder;
    v1::JournalRecord record;
    *record.mutable_header() = reader->header();
    encoder.add(record);
    std::string bytes = std::string(journal::kMagic) + encoder.take();
    bool found = false;
    while (reader->next(record)) {
      if (!found && record.has_wire()) found = change(*record.mutable_wire());
      encoder.add(record);
      if (encoder.pending() >= journal::kFrameBytes) bytes += encoder.take();
    }
    EXPECT_TRUE(found);
    return directory_.write("changed.journal", bytes + encoder.take());
  }

  TemporaryDirectory directory_;
  std::string file_ = directory_.path() + "/run.journal";
};

bool sent_by(const v1::JournalWire& wire, const std::string& listener, std::uint64_t step) {
  return wire.content() == v1::WIRE_CONTENT_SENT && wire.listener() == listener &&
         wire.time().step() >= step;
}

/// Makes the number before a word another one.
bool change_before(std::string& text, const std::string& end) {
  const auto at = text.find(end);
  if (at == std::string::npos) return false;
  const auto first = text.find_last_not_of("0123456789.", at - 1) + 1;
  if (first == at) return false;
  text[first] = text[first] == '9' ? '8' : static_cast<char>(text[first] + 1);
  return true;
}

TEST_F(ReplayOfWires, GivesAllRepliesAgainAndNamesTheFirstThatIsAnotherOne) {
  const auto whole = replayed(file_);
  EXPECT_EQ(whole["same"], true) << whole;
  EXPECT_GT(whole["replies"], 200) << whole;
  EXPECT_EQ(whole["reply"], nullptr);
  // From a checkpoint on fewer are compared, and none is taken for another one.
  const auto half = replayed(file_, {"--from", "10.5"});
  EXPECT_EQ(half["same"], true) << half;
  EXPECT_GT(half["replies"], 20) << half;
  EXPECT_LT(half["replies"], whole["replies"]);

  struct Case {
    std::string listener, says;
    Change change;
  };
  const std::uint64_t step = 2000;
  const auto document = [&](const std::string& listener, const std::string& end) {
    return [=](v1::JournalWire& wire) {
      return sent_by(wire, listener, step) && change_before(*wire.mutable_data(), end);
    };
  };
  const std::vector<Case> cases{
      {"crcl.fanuc", "position of joint 1", document("crcl.fanuc", "</JointPosition>")},
      {"crcl.motoman", "position of joint 1", document("crcl.motoman", "</JointPosition>")},
      {"crcl.motoman", "pose x", document("crcl.motoman", "</X>")},
      {"crcl.fanuc", "separation", document("crcl.fanuc", "</Separation>")},
      {"modbus", "(0x8004) by 1",
       [&](v1::JournalWire& wire) {
         // The low word of the position of the belt is in the sixth register.
         if (!sent_by(wire, "modbus", step) || wire.data().size() < 30) return false;
         (*wire.mutable_data())[9 + 2 * 4 + 1] ^= 1;
         return true;
       }},
      {"modbus.line", "belt.travel_m (0x0007) by 0.0",
       [&](v1::JournalWire& wire) {
         if (!sent_by(wire, "modbus.line", step)) return false;
         (*wire.mutable_data())[9 + 3] ^= 64;  // more than the belt goes meanwhile
         return true;
       }},
      {"vision.fanuc", "a line that the camera does not send", [&](v1::JournalWire& wire) {
         return sent_by(wire, "vision.fanuc", step) && change_before(*wire.mutable_data(), ",P,");
       }}};
  for (const Case& one : cases) {
    std::uint64_t at = 0;
    const std::string file = changed([&](v1::JournalWire& wire) {
      at = wire.time().step();
      return one.change(wire);
    });
    const auto found = replayed(file);
    EXPECT_EQ(found["same"], false) << one.listener << one.says;
    EXPECT_EQ(found["difference"], nullptr) << found;
    ASSERT_NE(found["reply"], nullptr) << one.listener << one.says;
    EXPECT_EQ(found["reply"]["step"], at);
    const std::string what = found["reply"]["text"];
    EXPECT_TRUE(what.starts_with(one.listener + " to 127.0.0.1:")) << what;
    EXPECT_NE(what.find(one.says), std::string::npos) << what;
  }
}

TEST_F(ReplayOfWires, SaysWhenARobotDoesOtherwise) {
  // As in another build whose arm is a little off: the first reply after it differs before a state.
  auto reader = journal::JournalReader::open(file_);
  journal::FrameEncoder encoder;
  v1::JournalRecord record;
  *record.mutable_header() = reader->header();
  record.mutable_header()->set_world_sha256(std::string(64, '0'));
  encoder.add(record);
  std::string bytes = std::string(journal::kMagic) + encoder.take();
  std::uint64_t at = 0;
  while (reader->next(record)) {
    // Every move of the Fanuc, so that a sampled state differs whenever the samples are.
    const auto& command = record.command().robot();
    if (command.has_move_joints() && command.robot() == 0) {
      if (at == 0) at = record.command().time().step();
      auto& joint =
          *record.mutable_command()->mutable_robot()->mutable_move_joints()->mutable_targets(0);
      joint.set_position_rad(joint.position_rad() + 1e-4);
    }
    encoder.add(record);
    if (encoder.pending() >= journal::kFrameBytes) bytes += encoder.take();
  }
  ASSERT_GT(at, 0U);
  const auto found = replayed(directory_.write("other.journal", bytes + encoder.take()));
  EXPECT_EQ(found["same"], false);
  ASSERT_NE(found["difference"], nullptr) << found;
  ASSERT_NE(found["reply"], nullptr) << found;
  EXPECT_LE(found["reply"]["step"], found["difference"]["step"]);
  const std::string what = found["reply"]["text"];
  EXPECT_TRUE(what.starts_with("crcl.fanuc to 127.0.0.1:")) << what;
  EXPECT_NE(what.find(" by "), std::string::npos) << what;
  ASSERT_EQ(found["cautions"].size(), 1U) << found;
  EXPECT_NE(std::string(found["cautions"][0]).find("other sources"), std::string::npos) << found;
}

}  // namespace
}  // namespace aprsim::test
