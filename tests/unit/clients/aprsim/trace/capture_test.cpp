#include "clients/aprsim/trace/capture.hpp"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "clients/aprsim/trace/action.hpp"
#include "clients/aprsim/trace/trace.hpp"
#include "tests/support/capture_file.hpp"
#include "tests/support/journal_file.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::trace {
namespace {

using test::CapturedConnection;
using test::CaptureFile;
using test::JournalFile;
using Link = test::CaptureFile::Link;

struct ImportResult {
  Result<Imported> imported;
  Trace trace;
};

ImportResult import(const std::string& bytes, const ListenerPorts& ports = usual_ports()) {
  const test::TemporaryDirectory directory;
  const std::string capture = directory.path() + "/lab.pcap", journal = directory.path() + "/lab";
  std::ofstream(capture, std::ios::binary) << bytes;
  ImportResult out{import_capture(capture, journal, ports), {}};
  if (out.imported) {
    auto trace = read_trace(journal);
    EXPECT_TRUE(trace) << (trace ? "" : trace.error().message);
    if (trace) out.trace = *trace;
  }
  return out;
}

const std::string kInit = JournalFile::instance(1, "InitCanonType", "");
const std::string kDwell = JournalFile::instance(2, "DwellType", "<DwellTime>0.5</DwellTime>");
const std::string kDone = JournalFile::status(2, "CRCL_Done", "");

std::vector<Action> fanuc_actions(const Trace& trace) {
  return actions_of(trace).at("crcl.fanuc").actions;
}

TEST(Capture, EveryLinkAndBothVersionsOfIp) {
  for (const Link link :
       {Link::kEthernet, Link::kRaw, Link::kCooked, Link::kCooked2, Link::kNull}) {
    for (const bool ipv6 : {false, true}) {
      for (const bool vlan : {false, true}) {
        if (vlan && link != Link::kEthernet) continue;
        CaptureFile file(link, ipv6);
        file.vlan = vlan;
        CapturedConnection robot(file, 50000, 64444);
        robot.open(1);
        robot.sends(1.1, kInit + kDwell);
        robot.answers(1.75, kDone);
        robot.close(2);
        const auto [imported, trace] = import(file.bytes());
        ASSERT_TRUE(imported) << imported.error().message;
        EXPECT_TRUE(imported->notes.empty()) << imported->notes.front();
        const auto actions = fanuc_actions(trace);
        ASSERT_EQ(actions.size(), 2U);
        EXPECT_EQ(actions[1].kind, "Dwell");
        EXPECT_EQ(actions[1].outcome, "done");
        EXPECT_NEAR(actions[1].time_s, 0.1, 1e-6);  // since the first packet
        EXPECT_NEAR(*actions[1].duration_s, 0.65, 1e-6);
        EXPECT_EQ(trace.wires.front().wire.peer(), ipv6 ? "[::1]:50000" : "127.0.0.1:50000");
        EXPECT_EQ(trace.wires.back().wire.content(), v1::WIRE_CONTENT_CLOSED);
      }
    }
  }
}

/// The documents that a robot was sent, however their segments come.
class SegmentsTest : public testing::Test {
 protected:
  SegmentsTest() : connection_(file_, 50000, 64444) {
    connection_.open(0);
    first_ = connection_.sequence();
    for (int i = 1; i <= 20; ++i) {
      sent_.push_back(
          JournalFile::instance(i, "DwellType", fmt::format("<DwellTime>{}</DwellTime>", i)));
      stream_ += sent_.back();
    }
  }
  /// A piece of the stream, at a time.
  void piece(double time_s, std::size_t begin, std::size_t size) {
    file_.packet(time_s, 50000, 64444, first_ + static_cast<std::uint32_t>(begin),
                 connection_.acknowledged(), "A", stream_.substr(begin, size));
  }
  std::vector<std::string> received() {
    const auto [imported, trace] = import(file_.bytes());
    std::vector<std::string> out;
    for (const auto& record : trace.wires) {
      if (record.wire.content() == v1::WIRE_CONTENT_RECEIVED) out.push_back(record.wire.data());
    }
    return out;
  }

  CaptureFile file_;
  CapturedConnection connection_;
  std::uint32_t first_ = 0;
  std::vector<std::string> sent_;
  std::string stream_;
};

TEST_F(SegmentsTest, ByteForByteAndOverTheWrapOfTheirNumbers) {
  for (std::size_t at = 0; at < stream_.size(); ++at) piece(0.001 * static_cast<double>(at), at, 1);
  EXPECT_EQ(received(), sent_);
}

TEST_F(SegmentsTest, OutOfOrderTwiceAndOverlapping) {
  std::mt19937 random(3);
  struct Piece {
    std::size_t begin, size;
  };
  std::vector<Piece> pieces;
  for (std::size_t at = 0; at < stream_.size();) {
    const std::size_t size = 1 + random() % 90;
    // Some begin before their place, some go beyond it.
    const std::size_t before = std::min<std::size_t>(at, random() % 3 == 0 ? random() % 40 : 0);
    pieces.push_back({at - before, before + size + (random() % 4 == 0 ? 25 : 0)});
    if (random() % 4 == 0) pieces.push_back(pieces.back());
    at += size;
  }
  // Each moves by a few places.
  for (std::size_t i = 0; i + 6 < pieces.size(); ++i)
    std::swap(pieces[i], pieces[i + random() % 6]);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    piece(0.001 * static_cast<double>(i), pieces[i].begin, pieces[i].size);
  }
  EXPECT_EQ(received(), sent_);
}

TEST_F(SegmentsTest, MissingBytesAreAGap) {
  const std::size_t size = sent_[0].size();
  piece(0, 0, size + 30);
  piece(0.1, size + 90, stream_.size() - size - 90);  // 60 bytes of the second document are gone
  // The robot says that it has all.
  file_.packet(0.2, 64444, 50000, connection_.acknowledged(),
               first_ + static_cast<std::uint32_t>(stream_.size()), "A");
  const auto [imported, trace] = import(file_.bytes());
  ASSERT_TRUE(imported);
  ASSERT_EQ(imported->notes.size(), 1U);
  EXPECT_EQ(imported->notes[0], "1 gap in the captured bytes of a connection");
  const auto actions = fanuc_actions(trace);
  ASSERT_EQ(actions.size(), 19U);
  for (const Action& action : actions) EXPECT_EQ(action.kind, "Dwell");
}

TEST_F(SegmentsTest, AConnectionThatWasOpenBeforeTheCapture) {
  CaptureFile file;
  const std::size_t in_second = sent_[0].size() + 40;
  file.packet(0, 50000, 64444, 77, 0, "A", stream_.substr(in_second));
  const auto [imported, trace] = import(file.bytes());
  EXPECT_EQ(fanuc_actions(trace).size(), 18U);
}

TEST(Capture, SeveralConnectionsAndWiresAtOnce) {
  CaptureFile file;
  CapturedConnection fanuc(file, 50000, 64444), motoman(file, 50000, 64445),
      belt(file, 50001, 1502), camera(file, 50002, 4000), other(file, 50003, 8080);
  for (CapturedConnection* one : {&fanuc, &motoman, &belt, &camera, &other}) one->open(0);
  fanuc.sends(0.1, kInit.substr(0, 50));
  motoman.sends(0.1, kInit);
  other.sends(0.1, "GET / HTTP/1.1\r\n\r\n");
  fanuc.sends(0.2, kInit.substr(50));
  const std::string write{0, 5, 0, 0, 0, 6, 1, 6, '\x80', 2, '\x27', '\x10'};
  belt.sends(0.3, write.substr(0, 5));
  belt.sends(0.3, write.substr(5));
  belt.answers(0.31, write);
  camera.answers(0.4, "part_large_gear,0.1,100,50,0.9,P,part_large_");
  camera.answers(0.5, "gear,0.2,300,50,0.9,P,\n");
  const auto [imported, trace] = import(file.bytes());
  ASSERT_TRUE(imported);
  EXPECT_EQ(imported->connections, 4U);
  const auto wires = actions_of(trace);
  EXPECT_EQ(wires.size(), 4U);
  EXPECT_EQ(wires.at("crcl.fanuc").actions.size(), 1U);
  EXPECT_EQ(wires.at("crcl.motoman").actions.size(), 1U);
  ASSERT_EQ(wires.at("modbus").actions.size(), 1U);
  EXPECT_EQ(wires.at("modbus").actions[0].kind, "write speed");
  EXPECT_EQ(wires.at("modbus").actions[0].outcome, "done");
  EXPECT_EQ(wires.at("vision.fanuc").seen.size(), 2U);
}

TEST(Capture, ReusedPortIsAnotherConnection) {
  CaptureFile file;
  for (const double time_s : {0.0, 1.0, 2.0}) {
    CapturedConnection robot(file, 50000, 64444, static_cast<std::uint32_t>(1000 * time_s));
    robot.open(time_s);
    robot.sends(time_s + 0.1, kInit);
    // The second is reset, the first and the last are left as they are.
    if (time_s == 1) file.packet(1.2, 64444, 50000, robot.acknowledged(), 0, "R");
  }
  const auto [imported, trace] = import(file.bytes());
  EXPECT_EQ(imported->connections, 3U);
  EXPECT_EQ(fanuc_actions(trace).size(), 3U);
}

std::string words(std::initializer_list<std::uint32_t> all) {
  std::string out;
  for (const std::uint32_t word : all) {
    for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(word >> shift & 0xFFU);
  }
  return out;
}

std::vector<std::string> data_of(const Trace& trace, const std::string& listener,
                                 v1::WireContent content) {
  std::vector<std::string> out;
  for (const auto& record : trace.wires) {
    if (record.wire.listener() == listener && record.wire.content() == content) {
      EXPECT_EQ(record.wire.kind(), v1::WIRE_KIND_SIMPLE_MESSAGE);
      out.push_back(record.wire.data());
    }
  }
  return out;
}

TEST(Capture, SimpleMessageIsCutWhereverItsSegmentsEnd) {
  const std::string state = words({56, 10, 1, 0, 0}) + std::string(40, '\1');
  const std::string status = words({40, 13, 1, 0, 2, 0, 0, 0, 2, 1, 1});
  // A point of a client that states a length of its own: Karel reads the joints.
  const std::string point = words({64, 11, 2, 0, 7}) + std::string(48, '\2');
  const std::string read_io = words({16, 2003, 2, 0, 10010});
  const std::string read_reply = words({20, 2004, 3, 1, 1, 0});
  std::mt19937 random(5);
  for (int round = 0; round < 20; ++round) {
    CaptureFile file(Link::kEthernet, false);
    CapturedConnection states(file, 50000, 11002), motion(file, 50001, 11000);
    CapturedConnection gripper(file, 50002, 12123), valves(file, 50003, 50242);
    for (CapturedConnection* one : {&states, &motion, &gripper, &valves}) one->open(0);
    const auto pieces = [&](const std::string& bytes, auto&& send) {
      for (std::size_t at = 0; at < bytes.size();) {
        const std::size_t size = 1 + random() % 70;
        send(bytes.substr(at, size));
        at += size;
      }
    };
    pieces(state + status + state, [&](const std::string& one) { states.answers(1, one); });
    pieces(point + point, [&](const std::string& one) { motion.sends(2, one); });
    gripper.sends(3, words({1}));
    gripper.answers(3, words({1}));
    gripper.sends(3, words({3}) + words({99}));
    pieces(read_io + read_io, [&](const std::string& one) { valves.sends(4, one); });
    pieces(read_reply, [&](const std::string& one) { valves.answers(5, one); });
    const auto [imported, trace] = import(file.bytes());
    ASSERT_TRUE(imported) << imported.error().message;
    using Units = std::vector<std::string>;
    constexpr auto kSent = v1::WIRE_CONTENT_SENT, kReceived = v1::WIRE_CONTENT_RECEIVED;
    EXPECT_EQ(data_of(trace, "state.fanuc", kSent), (Units{state, status, state}));
    EXPECT_EQ(data_of(trace, "motion.fanuc", kReceived), (Units{point, point}));
    EXPECT_EQ(data_of(trace, "gripper.fanuc", kReceived),
              (Units{words({1}), words({3}), words({99})}));
    EXPECT_EQ(data_of(trace, "gripper.fanuc", kSent), Units{words({1})});
    EXPECT_EQ(data_of(trace, "gripper.motoman", kReceived), (Units{read_io, read_io}));
    EXPECT_EQ(data_of(trace, "gripper.motoman", kSent), Units{read_reply});
  }
}

TEST(Capture, PortsAreConfigurable) {
  CaptureFile file;
  CapturedConnection robot(file, 50000, 7001);
  robot.open(0);
  robot.sends(0.1, kInit);
  EXPECT_EQ(import(file.bytes()).imported->records, 0U);
  const auto [imported, trace] = import(file.bytes(), {{7001, "crcl.fanuc"}});
  EXPECT_EQ(fanuc_actions(trace).size(), 1U);
  EXPECT_TRUE(is_listener_name("crcl.x"));
  EXPECT_TRUE(is_listener_name("state.fanuc"));
  EXPECT_FALSE(is_listener_name("gripper."));
  EXPECT_FALSE(is_listener_name("crcl."));
  EXPECT_FALSE(is_listener_name("grpc"));
}

TEST(Capture, TruncatedCaptureIsReadToItsEnd) {
  CaptureFile file;
  CapturedConnection robot(file, 50000, 64444);
  robot.open(0);
  robot.sends(0.1, kInit);
  robot.sends(0.2, kDwell);
  for (const std::size_t cut : {std::size_t{1}, kDwell.size(), kDwell.size() + 70}) {
    const auto [imported, trace] = import(file.bytes().substr(0, file.bytes().size() - cut));
    ASSERT_TRUE(imported) << imported.error().message;
    ASSERT_EQ(imported->notes.size(), 1U);
    EXPECT_NE(imported->notes[0].find("ends early"), std::string::npos);
    EXPECT_EQ(fanuc_actions(trace).size(), 1U);
  }
}

TEST(Capture, TruncatedPacketsAreNoted) {
  CaptureFile file;
  CapturedConnection robot(file, 50000, 64444);
  robot.open(0);
  robot.sends(0.1, kInit);
  file.packet(0.2, 50000, 64444, robot.sequence(), robot.acknowledged(), "A", kDwell, 60);
  robot.loses(kDwell);
  robot.sends(0.3, JournalFile::instance(3, "EndCanonType", ""));
  robot.answers(0.4, JournalFile::status(3, "CRCL_Done", ""));
  const auto [imported, trace] = import(file.bytes());
  ASSERT_EQ(imported->notes.size(), 2U);
  EXPECT_NE(imported->notes[0].find("in part"), std::string::npos);
  const auto actions = fanuc_actions(trace);
  ASSERT_EQ(actions.size(), 2U);
  EXPECT_EQ(actions[1].kind, "EndCanon");
}

TEST(Capture, OtherFilesAreRefused) {
  for (const std::string& bytes : {std::string(), std::string("no capture at all, but text"),
                                   CaptureFile().bytes().substr(0, 20)}) {
    const auto [imported, trace] = import(bytes);
    ASSERT_FALSE(imported);
    EXPECT_NE(imported.error().message.find("lab.pcap"), std::string::npos)
        << imported.error().message;
  }
  CaptureFile usb;
  usb.bytes()[20] = 105;  // IEEE 802.11
  const auto [refused, none] = import(usb.bytes());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("cannot be read"), std::string::npos);
  EXPECT_FALSE(import_capture("/nowhere/at/all", "/tmp/none", usual_ports()));
}

/// A capture of one connection to a robot, whose frames are made from IP packets.
CaptureFile robot_capture(Link link, std::function<std::string(const std::string&)> frame_of) {
  CaptureFile file(link);
  file.frame_of = std::move(frame_of);
  CapturedConnection robot(file, 50000, 64444);
  robot.open(1);
  robot.sends(1.1, kInit + kDwell);
  robot.answers(1.75, kDone);
  robot.close(2);
  return file;
}

TEST(Capture, EncapsulatedPacketsAreRead) {
  using test::bytes16, test::ethernet_frame, test::ipv4_packet, test::udp_datagram;
  using Frame = std::function<std::string(const std::string&)>;
  const std::vector<std::tuple<const char*, Link, Frame>> cases{
      {"cooked, VLAN tag", Link::kCooked,
       [](const auto& ip) {
         return std::string(14, '\0') + bytes16({0x8100, 7, 0x0800}) + ip;
       }},
      {"cooked 2, VLAN tag", Link::kCooked2,
       [](const auto& ip) {
         return bytes16({0x8100}) + std::string(18, '\0') + bytes16({7, 0x0800}) + ip;
       }},
      {"two VLAN tags, outer 0x9100", Link::kEthernet,
       [](const auto& ip) {
         return ethernet_frame(0x9100, bytes16({7, 0x8100, 8, 0x0800}) + ip);
       }},
      {"LLC and SNAP", Link::kEthernet,
       [](const auto& ip) {
         return ethernet_frame(static_cast<unsigned>(ip.size() + 8),
                               bytes16({0xAAAA, 0x0300, 0, 0x0800}) + ip);
       }},
      {"two MPLS labels", Link::kEthernet,
       [](const auto& ip) {
         return ethernet_frame(0x8847, bytes16({0x0001, 0x0040, 0x0002, 0x0140}) + ip);
       }},
      {"PPPoE", Link::kEthernet,
       [](const auto& ip) {
         return ethernet_frame(
             0x8864, bytes16({0x1100, 1, static_cast<unsigned>(ip.size() + 2), 0x0021}) + ip);
       }},
      {"GRE", Link::kEthernet,
       [](const auto& ip) {
         return ethernet_frame(0x0800, ipv4_packet(47, bytes16({0, 0x0800}) + ip));
       }},
      {"ERSPAN type I", Link::kEthernet,
       [](const auto& ip) {
         return ethernet_frame(0x0800,
                               ipv4_packet(47, bytes16({0, 0x88BE}) + ethernet_frame(0x0800, ip)));
       }},
      {"ERSPAN type II", Link::kEthernet,
       [](const auto& ip) {
         return ethernet_frame(0x0800,
                               ipv4_packet(47, bytes16({0x1000, 0x88BE, 0, 1, 0x1007, 0, 0, 0}) +
                                                   ethernet_frame(0x0800, ip)));
       }},
      {"ERSPAN type III", Link::kEthernet,
       [](const auto& ip) {
         return ethernet_frame(
             0x0800, ipv4_packet(47, bytes16({0x1000, 0x22EB, 0, 1, 0x2007, 0, 0, 0, 0, 0}) +
                                         ethernet_frame(0x0800, ip)));
       }},
      {"IP in IP", Link::kRaw, [](const auto& ip) { return ipv4_packet(4, ip); }},
      {"VXLAN", Link::kEthernet,
       [](const auto& ip) {
         return ethernet_frame(0x0800,
                               ipv4_packet(17, udp_datagram(40000, 4789,
                                                            bytes16({0x0800, 0, 0, 0x0700}) +
                                                                ethernet_frame(0x0800, ip))));
       }},
      {"Geneve", Link::kEthernet,
       [](const auto& ip) {
         return ethernet_frame(0x0800,
                               ipv4_packet(17, udp_datagram(40000, 6081,
                                                            bytes16({0, 0x6558, 0, 0x0700}) +
                                                                ethernet_frame(0x0800, ip))));
       }},
  };
  for (const auto& [name, link, frame_of] : cases) {
    const auto [imported, trace] = import(robot_capture(link, frame_of).bytes());
    ASSERT_TRUE(imported) << name << ": " << imported.error().message;
    EXPECT_TRUE(imported->notes.empty()) << name << ": " << imported->notes.front();
    EXPECT_EQ(imported->connections, 1U) << name;
    EXPECT_EQ(fanuc_actions(trace).size(), 2U) << name;
  }
}

TEST(Capture, EncapsulationThatIsNotReadIsCountedAndNamed) {
  using test::ethernet_frame, test::ipv4_packet;
  const auto macsec = robot_capture(Link::kEthernet, [](const auto& ip) {
    return ethernet_frame(0x88E5, std::string(8, 'x') + ip);
  });
  const auto [secured, nothing] = import(macsec.bytes());
  ASSERT_TRUE(secured) << secured.error().message;
  EXPECT_EQ(secured->connections, 0U);
  EXPECT_EQ(secured->skipped, secured->packets);
  ASSERT_EQ(secured->notes.size(), 1U);
  EXPECT_EQ(secured->notes[0],
            fmt::format("{} packets of EtherType 0x88e5 (MACsec) were not read", secured->packets));
  const auto esp = robot_capture(Link::kEthernet, [](const auto& ip) {
    return ethernet_frame(0x0800, ipv4_packet(50, std::string(8, 'x') + ip));
  });
  const auto [encrypted, none] = import(esp.bytes());
  ASSERT_EQ(encrypted->notes.size(), 1U);
  EXPECT_NE(encrypted->notes[0].find("IP protocol 50 (ESP)"), std::string::npos);
  // ARP has no TCP in it: there is nothing to report.
  const auto arp = robot_capture(
      Link::kEthernet, [](const auto&) { return ethernet_frame(0x0806, std::string(28, '\0')); });
  EXPECT_TRUE(import(arp.bytes()).imported->notes.empty());
}

TEST(Capture, TheSideThatAnswersTheSynIsTheServer) {
  // The client's port is one of the listeners', as a Linux client's may be by chance.
  const std::string write{0, 5, 0, 0, 0, 6, 1, 6, '\x80', 2, '\x27', '\x10'};
  for (const std::uint16_t client : {std::uint16_t{64444}, std::uint16_t{502}}) {
    CaptureFile file(Link::kRaw);
    // The hosts 10.0.0.1 and 10.0.0.2, of which the client is the first.
    const auto between = [&file](char from, char to) {
      file.frame_of = [from, to](std::string ip) {
        return ip.replace(12, 8, {10, 0, 0, from, 10, 0, 0, to});
      };
    };
    const auto request_packet = [&](double time_s, unsigned sequence, unsigned acknowledged,
                                    const char* flags, const std::string& payload) {
      between(1, 2);
      file.packet(time_s, client, 502, sequence, acknowledged, flags, payload);
    };
    const auto reply_packet = [&](double time_s, unsigned sequence, unsigned acknowledged,
                                  const char* flags, const std::string& payload) {
      between(2, 1);
      file.packet(time_s, 502, client, sequence, acknowledged, flags, payload);
    };
    request_packet(0, 100, 0, "S", "");
    reply_packet(0, 900, 101, "SA", "");
    request_packet(0.1, 101, 901, "A", write);
    reply_packet(0.2, 901, 113, "A", write);
    const auto [imported, trace] = import(file.bytes());
    ASSERT_TRUE(imported) << imported.error().message;
    const auto wires = actions_of(trace);
    ASSERT_TRUE(wires.contains("modbus")) << client;
    ASSERT_EQ(wires.at("modbus").actions.size(), 1U) << client;
    EXPECT_EQ(wires.at("modbus").actions[0].outcome, "done") << client;
    EXPECT_EQ(trace.wires.front().wire.peer(), fmt::format("10.0.0.1:{}", client));
  }
  // A program whose own port is that of a robot by chance talks to something else.
  CaptureFile web;
  CapturedConnection browser(web, 64444, 8080);
  browser.open(0);
  browser.sends(0.1, "GET / HTTP/1.1\r\n\r\n");
  EXPECT_EQ(import(web.bytes()).imported->connections, 0U);
}

TEST(Capture, ACompressedCaptureSaysHowToUnpackIt) {
  const auto [refused, none] = import("\x1f\x8b\x08 and what follows in a compressed file");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("unpack it with gunzip first"), std::string::npos)
      << refused.error().message;
}

TEST(Capture, AnOutputThatIsTheCaptureIsRefusedAndLeavesIt) {
  const std::string bytes = robot_capture(Link::kEthernet, {}).bytes();
  const test::TemporaryDirectory directory;
  const std::string capture = directory.path() + "/lab.pcap";
  std::ofstream(capture, std::ios::binary) << bytes;
  std::filesystem::create_hard_link(capture, directory.path() + "/hard");
  std::filesystem::create_symlink(capture, directory.path() + "/soft");
  for (const char* output : {"/lab.pcap", "/./lab.pcap", "/hard", "/soft"}) {
    const auto imported = import_capture(capture, directory.path() + output, usual_ports());
    ASSERT_FALSE(imported) << output;
    EXPECT_NE(imported.error().message.find("is the same file as the input"), std::string::npos)
        << imported.error().message;
    std::ifstream in(capture, std::ios::binary);
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), bytes) << output;
  }
}

TEST(Capture, AFailedImportLeavesTheJournalThatWasThere) {
  const test::TemporaryDirectory directory;
  const std::string capture = directory.path() + "/none.pcap", journal = directory.path() + "/lab";
  std::ofstream(capture) << "no capture";
  std::ofstream(journal) << "a journal from before";
  EXPECT_FALSE(import_capture(capture, journal, usual_ports()));
  std::ifstream in(journal);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "a journal from before");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(directory.path()), {}), 2);
}

TEST(Capture, ANameThatIsNoUtf8IsImported) {
  const test::TemporaryDirectory directory;
  const std::string capture = directory.path() + "/lab\xff.pcap",
                    journal = directory.path() + "/lab";
  std::ofstream(capture, std::ios::binary) << robot_capture(Link::kEthernet, {}).bytes();
  ASSERT_TRUE(import_capture(capture, journal, usual_ports()));
  const auto trace = read_trace(journal);
  ASSERT_TRUE(trace) << trace.error().message;
  EXPECT_EQ(trace->header.run_id(), "capture lab\\xff.pcap");
}

TEST(Capture, DamageAnywhereIsSurvived) {
  CaptureFile file(Link::kEthernet, true);
  CapturedConnection robot(file, 50000, 64444), belt(file, 50001, 502);
  robot.open(0);
  belt.open(0);
  for (int i = 0; i < 5; ++i) {
    robot.sends(0.1 * i, kInit + kDwell.substr(0, 30));
    robot.sends(0.1 * i, kDwell.substr(30));
    robot.answers(0.1 * i, kDone);
    belt.sends(0.1 * i, std::string{0, 1, 0, 0, 0, 6, 1, 6, '\x80', 2, 0, 1});
  }
  robot.close(1);
  std::mt19937 random(11);
  for (int round = 0; round < 300; ++round) {
    std::string bytes = file.bytes();
    for (int change = 0; change < 1 + round % 20; ++change) {
      bytes[24 + random() % (bytes.size() - 24)] = static_cast<char>(random());
    }
    const auto [imported, trace] = import(bytes);
    if (!imported) continue;
    EXPECT_LE(actions_of(trace).size(), 6U);
  }
}

}  // namespace
}  // namespace aprsim::trace
