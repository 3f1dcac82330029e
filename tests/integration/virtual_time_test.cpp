// Virtual time: the daemon and clients over sockets that ask as fast as they can.

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/vision_client.hpp"

namespace aprsim::test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kPollSteps = 25;

std::vector<std::string> in_virtual_time(const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"--time", "virtual", "--no-web"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

/// A Modbus client that waits for each answer.
class BeltClient {
 public:
  explicit BeltClient(std::uint16_t port) : socket_(port) {}

  /// Simulated time of the belt's registers [ms].
  std::uint32_t time_ms() {
    const std::string answer = ask({4, '\x80', 6, 0, 2}, 13);
    std::uint32_t value = 0;
    for (std::size_t i = 9; i < 13; ++i) {
      value = value << 8 | static_cast<unsigned char>(answer[i]);
    }
    return value;
  }
  void write(char low_address, std::uint16_t value) {
    ask({6, '\x80', low_address, static_cast<char>(value >> 8), static_cast<char>(value & 0xff)},
        12);
  }

 private:
  std::string ask(const std::vector<char>& pdu, std::size_t answer_bytes) {
    std::string frame{0, 1, 0, 0, 0, static_cast<char>(pdu.size() + 1), 1};
    frame.append(pdu.begin(), pdu.end());
    if (!socket_.send(frame)) throw std::runtime_error("the PLC does not read");
    const auto deadline = TcpSocket::Clock::now() + 30s;
    std::string answer;
    while (answer.size() < answer_bytes) {
      const std::string bytes = socket_.receive(deadline);
      if (bytes.empty()) throw std::runtime_error("closed while an answer was expected");
      answer += bytes;
    }
    return answer;
  }

  TcpSocket socket_;
};

std::string actuate_first(double degrees) {
  return "<ActuateJoint><JointNumber>1</JointNumber><JointPosition>" + std::to_string(degrees) +
         "</JointPosition><JointDetails xsi:type=\"JointSpeedAccelType\"/></ActuateJoint>";
}

TEST(VirtualTime, APollTakesItsPeriodHoweverFastItComes) {
  DaemonProcess daemon(in_virtual_time({"--pacers", "crcl.fanuc"}));
  CellClient cell(daemon.port("grpc"));
  EXPECT_EQ(cell.snapshot().virtual_time().awaited(0), "crcl.fanuc");
  CrclTextClient client(daemon.port("crcl.fanuc"));
  for (std::uint64_t poll = 1; poll <= 40; ++poll) {
    (void)client.status();
    ASSERT_EQ(cell.snapshot().step(), poll * kPollSteps);
  }
  EXPECT_TRUE(cell.snapshot().virtual_time().reproducible());
  EXPECT_EQ(cell.snapshot().virtual_time().pacers(0), "crcl.fanuc");
}

TEST(VirtualTime, ThePeriodIsAnOption) {
  DaemonProcess daemon(in_virtual_time({"--pacers", "crcl.fanuc", "--poll-period", "8ms"}));
  CellClient cell(daemon.port("grpc"));
  CrclTextClient client(daemon.port("crcl.fanuc"));
  (void)client.status();
  EXPECT_EQ(cell.snapshot().step(), 8U);
}

TEST(VirtualTime, ACommandTakesEffectWhereItsClientStands) {
  DaemonProcess daemon(in_virtual_time({"--pacers", "crcl.fanuc"}));
  CellClient cell(daemon.port("grpc"));
  CrclTextClient client(daemon.port("crcl.fanuc"));
  client.run("InitCanonType");
  const auto begin = cell.snapshot().step();
  client.run("DwellType", "<DwellTime>0.100</DwellTime>");
  EXPECT_EQ(cell.snapshot().step() - begin, 4 * kPollSteps);
}

TEST(VirtualTime, ThreeClientsGoTogether) {
  DaemonProcess daemon(in_virtual_time({"--pacers", "crcl.fanuc,crcl.motoman,modbus"}));
  CellClient cell(daemon.port("grpc"));
  constexpr std::uint64_t kPolls = 40;
  std::atomic<std::uint64_t> fanuc_polls{0}, motoman_polls{0};
  const auto poll = [&](const std::string& wire, std::atomic<std::uint64_t>& polls) {
    CrclTextClient client(daemon.port(wire));
    for (; polls < kPolls; ++polls) (void)client.status();
    // Stays there until the end: time would wait for it.
    EXPECT_NO_THROW(cell.wait_for(
        [&](const auto& now) { return now.step() >= kPolls * kPollSteps; }, "the end"));
  };
  std::jthread fanuc([&] { poll("crcl.fanuc", fanuc_polls); });
  cell.wait_for(
      [](const auto& now) {
        const auto& awaited = now.virtual_time().awaited();
        return awaited.size() == 2 && awaited[0] == "crcl.motoman" && awaited[1] == "modbus";
      },
      "fanuc's client to be there");
  EXPECT_EQ(cell.snapshot().step(), 0U);
  EXPECT_EQ(fanuc_polls, 0U) << "no answer before all are there";
  std::jthread motoman([&] { poll("crcl.motoman", motoman_polls); });
  BeltClient belt(daemon.port("modbus"));
  for (std::uint64_t request = 1; request <= kPolls; ++request) {
    ASSERT_EQ(belt.time_ms(), request * kPollSteps);
    EXPECT_LE(fanuc_polls, request);
    EXPECT_LE(motoman_polls, request);
  }
}

TEST(VirtualTime, WithoutPacersTheWallClockPassesTimeAndSaysSo) {
  DaemonProcess daemon(in_virtual_time({"--set", "time.grace_ms=300"}));
  CellClient cell(daemon.port("grpc"));
  const auto alone = cell.wait_for([](const auto& now) { return now.step() > 20; }, "the clock");
  EXPECT_FALSE(alone.virtual_time().paced());
  EXPECT_FALSE(alone.virtual_time().reproducible());
  CrclTextClient client(daemon.port("crcl.fanuc"));
  (void)client.status();
  const auto paced = cell.snapshot();
  (void)client.status();
  const auto next = cell.snapshot();
  if (next.virtual_time().fallbacks() == paced.virtual_time().fallbacks()) {
    EXPECT_EQ(next.step() - paced.step(), kPollSteps);
  }
  // It only waits now.
  const auto fallback = cell.wait_for(
      [](const auto& now) { return !now.virtual_time().paced() && now.step() > 0; }, "the grace");
  EXPECT_GE(fallback.virtual_time().expired(), 1U);
  EXPECT_GE(fallback.virtual_time().fallbacks(), 2U);
  cell.wait_for([&](const auto& now) { return now.step() > fallback.step() + 20; }, "the clock");
  const auto result =
      run_process({APRSIM_BIN_DIR "/aprsim", "--ports-file", daemon.ports_file(), "status"});
  EXPECT_NE(result.out.find("follows the wall clock"), std::string::npos) << result.out;
  EXPECT_NE(daemon.log().find("no client paces"), std::string::npos) << daemon.log();
}

TEST(VirtualTime, DropsAPacerThatOnlyWaits) {
  DaemonProcess daemon(
      in_virtual_time({"--pacers", "crcl.fanuc,crcl.motoman", "--set", "time.grace_ms=300"}));
  CellClient cell(daemon.port("grpc"));
  CrclTextClient fanuc(daemon.port("crcl.fanuc")), motoman(daemon.port("crcl.motoman"));
  // Motoman's client waits after its one command, which is no poll.
  motoman.send("InitCanonType");
  for (int poll = 0; poll < 10; ++poll) (void)fanuc.status();
  const auto now = cell.snapshot();
  EXPECT_EQ(now.step(), 10 * kPollSteps);
  EXPECT_EQ(now.virtual_time().expired(), 1U);
  EXPECT_FALSE(now.virtual_time().reproducible());
  EXPECT_TRUE(now.virtual_time().paced());
}

TEST(VirtualTime, AStepAnswersWithTheCellThatItLeadsTo) {
  DaemonProcess daemon(in_virtual_time({"--pacers", "grpc"}));
  CellClient cell(daemon.port("grpc"));
  v1::StepRequest request;
  request.set_steps(25);
  request.mutable_read_mask()->add_paths("step");
  request.mutable_read_mask()->add_paths("conveyor");
  for (std::uint64_t call = 1; call <= 40; ++call) {
    grpc::ClientContext context;
    v1::StepResponse response;
    CellClient::require(cell.control->Step(&context, request, &response));
    ASSERT_EQ(response.snapshot().step(), call * 25);
    ASSERT_EQ(response.receipt().step(), call * 25);
    ASSERT_TRUE(response.snapshot().has_conveyor());
    ASSERT_TRUE(response.snapshot().robots().empty()) << "not asked for";
  }
}

TEST(VirtualTime, APausedCellAnswersWithoutTime) {
  DaemonProcess daemon(in_virtual_time({"--pacers", "crcl.fanuc"}));
  CellClient cell(daemon.port("grpc"));
  CrclTextClient client(daemon.port("crcl.fanuc"));
  (void)client.status();
  grpc::ClientContext context;
  v1::PauseResponse response;
  CellClient::require(cell.control->Pause(&context, {}, &response));
  (void)client.status();
  EXPECT_EQ(cell.snapshot().step(), kPollSteps);
  cell.step(3);
  EXPECT_EQ(cell.snapshot().step(), kPollSteps + 3);
}

TEST(VirtualTime, EveryFrameReachesItsReader) {
  DaemonProcess daemon(in_virtual_time({"--pacers", "crcl.fanuc,vision.fanuc"}));
  CellClient cell(daemon.port("grpc"));
  VisionClient camera(daemon.port("vision.fanuc"));
  CrclTextClient client(daemon.port("crcl.fanuc"));
  std::string lines;
  // Each frame is on its way before the answer to the poll of its time.
  for (int poll = 0; poll < 40; ++poll) (void)client.status();
  const auto frames = cell.snapshot().robots(0).vision().number();
  EXPECT_GE(frames, 10U);
  for (std::uint64_t frame = 1; frame < frames; ++frame) {
    EXPECT_FALSE(parse_vision_line(camera.line()).empty());
  }
}

/// Two threads a core that do nothing but run.
class Load {
 public:
  Load() {
    for (unsigned i = 0; i < 2 * std::thread::hardware_concurrency(); ++i) {
      threads_.emplace_back([](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
        }
      });
    }
  }

 private:
  std::vector<std::jthread> threads_;
};

/// Two robots that move and a belt that runs, each by a client of its own, beside a load on every
/// core; the hash of what came of it. The clients tell each other nothing.
std::uint64_t hash_of_a_run() {
  DaemonProcess daemon(in_virtual_time({"--pacers", "crcl.fanuc,crcl.motoman,modbus"}));
  constexpr std::uint64_t kEnd = 3000;
  CellClient cell(daemon.port("grpc"));
  const Load load;
  const auto work = [&](const std::string& wire, double first_deg, double second_deg) {
    CrclTextClient client(daemon.port(wire));
    std::uint64_t polls = 0;
    const auto run = [&](const std::string& type, const std::string& fields) {
      const auto id = client.send(type, fields);
      for (; polls < kEnd / kPollSteps; ++polls) {
        const std::string status = client.status();
        if (client.field(status, "CommandID") != std::to_string(id)) continue;
        if (client.field(status, "CommandState") == "CRCL_Done") return void(++polls);
      }
    };
    run("InitCanonType", "");
    while (polls < kEnd / kPollSteps) {
      run("ActuateJointsType", actuate_first(first_deg));
      run("SetEndEffectorType", "<Setting>0</Setting>");
      run("ActuateJointsType", actuate_first(second_deg));
      run("SetEndEffectorType", "<Setting>1</Setting>");
    }
    cell.wait_for([&](const auto& now) { return now.step() >= kEnd; }, "the end");
  };
  std::jthread fanuc([&] { work("crcl.fanuc", 10, -15); });
  std::jthread motoman([&] { work("crcl.motoman", -12, 9); });
  BeltClient belt(daemon.port("modbus"));
  belt.write(2, 4000);
  belt.write(0, 1);
  while (belt.time_ms() < kEnd) {
  }
  const auto end = cell.snapshot();
  EXPECT_EQ(end.step(), kEnd);
  EXPECT_TRUE(end.virtual_time().reproducible());
  EXPECT_GT(end.conveyor().travel_m(), 0.05);
  return end.state_hash();
}

TEST(VirtualTime, TheSameClientsGiveTheSameHashBesideALoadOnEveryCore) {
  const std::uint64_t first = hash_of_a_run();
  EXPECT_EQ(hash_of_a_run(), first);
  EXPECT_EQ(hash_of_a_run(), first);
}

TEST(VirtualTime, ARobotThatTheSceneLacksIsRefused) {
  const auto result = run_process(
      {APRSIM_BIN_DIR "/aprsimd", "--any-port", "--time", "virtual", "--pacers", "crcl.fanuk"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("time.pacers: crcl.fanuk: one of the robots fanuc, motoman"),
            std::string::npos)
      << result.err;
}

}  // namespace
}  // namespace aprsim::test
