// The journal's record of each wire, compared with the bytes that its clients sent and received.

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "aprsim/v1/web.pb.h"
#include "proto/journal/journal_reader.hpp"
#include "tests/support/cell_client.hpp"
#include "tests/support/crcl_text_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/raw_web_client.hpp"
#include "tests/support/tcp_socket.hpp"
#include "tests/support/temporary_directory.hpp"
#include "tests/support/vision_client.hpp"

namespace aprsim::test {
namespace {

/// Sends a request and returns its answer, which has the same size.
std::string ask_modbus(TcpSocket& socket, const std::string& request) {
  EXPECT_TRUE(socket.send(request));
  const auto deadline = TcpSocket::Clock::now() + std::chrono::seconds(30);
  std::string answer;
  while (answer.size() < request.size()) answer += socket.receive(deadline);
  return answer;
}

/// A journal's records of one listener, in order.
std::vector<v1::JournalWire> wires_of(const std::vector<v1::JournalWire>& all,
                                      const std::string& listener) {
  std::vector<v1::JournalWire> some;
  for (const auto& wire : all) {
    if (wire.listener() == listener) some.push_back(wire);
  }
  return some;
}

std::string contents(const std::vector<v1::JournalWire>& wires) {
  std::string letters;
  for (const auto& wire : wires) letters += "-orsc"[wire.content()];
  return letters;
}

class WireTrace : public testing::Test {
 protected:
  [[nodiscard]] std::vector<v1::JournalWire> read() const {
    auto reader = journal::JournalReader::open(file_);
    if (!reader) throw std::runtime_error(reader.error().message);
    std::vector<v1::JournalWire> wires;
    for (v1::JournalRecord record; reader->next(record);) {
      EXPECT_FALSE(record.has_gap());
      if (record.has_wire()) wires.push_back(record.wire());
    }
    EXPECT_EQ(reader->damage(), "");
    return wires;
  }

  TemporaryDirectory directory_;
  const std::string file_ = directory_.path() + "/run.journal";
};

TEST_F(WireTrace, RecordsEveryWireByteForByte) {
  const std::string init = CrclTextClient::document("InitCanonType", 7);
  // One register read, one written: the answer of a write repeats it.
  const std::string write("\0\1\0\0\0\6\1\6\x80\2\x27\x10", 12);
  std::string status, line, written;
  {
    DaemonProcess daemon({"--journal", file_});
    CrclTextClient fanuc(daemon.port("crcl.fanuc"));
    fanuc.raw(init);
    status = fanuc.status();
    TcpSocket belt(daemon.port("modbus"));
    written = ask_modbus(belt, write);
    VisionClient camera(daemon.port("vision.motoman"));
    line = camera.line();
    CellClient cell(daemon.port("grpc"));
    v1::SetSpeedRequest speed;
    speed.set_factor(2);
    v1::SetSpeedResponse response;
    grpc::ClientContext context;
    CellClient::require(cell.control->SetSpeed(&context, speed, &response));
    cell.snapshot();  // is no command
    RawWebClient page(daemon.port("web"));
    page.upgrade();
    v1::ViewerRequest pause;
    pause.mutable_pause();
    EXPECT_TRUE(page.ask(pause).ok());
    fanuc.vanish();
    EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  }
  const auto all = read();

  const auto crcl = wires_of(all, "crcl.fanuc");
  ASSERT_EQ(contents(crcl), "orrsc");
  EXPECT_EQ(crcl[1].data(), init);
  EXPECT_NE(crcl[2].data().find("GetStatusType"), std::string::npos);
  EXPECT_EQ(crcl[3].data(), status);
  EXPECT_EQ(crcl[3].kind(), v1::WIRE_KIND_CRCL);

  const auto modbus = wires_of(all, "modbus");
  ASSERT_EQ(contents(modbus), "orsc");
  EXPECT_EQ(modbus[1].data(), write);
  EXPECT_EQ(modbus[2].data(), written);

  const auto vision = wires_of(all, "vision.motoman");
  ASSERT_GE(vision.size(), 3U);
  EXPECT_EQ(vision[1].data(), line);
  EXPECT_TRUE(std::all_of(vision.begin() + 1, vision.end() - 1, [](const auto& wire) {
    return wire.content() == v1::WIRE_CONTENT_SENT;
  }));

  const auto grpc = wires_of(all, "grpc");
  ASSERT_EQ(contents(grpc), "orsc");
  EXPECT_EQ(grpc[1].method(), "/aprsim.v1.ControlService/SetSpeed");
  v1::SetSpeedRequest speed;
  ASSERT_TRUE(speed.ParseFromString(grpc[1].data()));
  EXPECT_EQ(speed.factor(), 2);
  v1::SetSpeedResponse response;
  ASSERT_TRUE(response.ParseFromString(grpc[2].data()));
  EXPECT_GT(response.receipt().ticket(), 0U);

  const auto web = wires_of(all, "web");
  ASSERT_EQ(contents(web), "orsc");
  v1::ViewerRequest pause;
  ASSERT_TRUE(pause.ParseFromString(web[1].data()));
  EXPECT_TRUE(pause.has_pause());

  // Each connection has a number and a peer of its own, from its opening to its end.
  std::map<std::uint64_t, std::string> peers;
  for (const auto& wire : all) {
    EXPECT_GT(wire.connection(), 0U);
    const auto [known, first] = peers.emplace(wire.connection(), wire.peer());
    EXPECT_EQ(first, wire.content() == v1::WIRE_CONTENT_OPENED);
    EXPECT_EQ(known->second, wire.peer());
  }
  EXPECT_EQ(peers.size(), 5U);
}

TEST_F(WireTrace, RecordsTheReasonOfARefusal) {
  {
    DaemonProcess daemon({"--journal", file_, "--no-web"});
    CrclTextClient fanuc(daemon.port("crcl.fanuc"));
    fanuc.raw(
        "<CRCLCommandInstance><CRCLCommand xsi:type=\"NoSuchType\">"
        "</CRCLCommand></CRCLCommandInstance>");
    TcpSocket belt(daemon.port("modbus"));
    // Protocol 5 is none.
    EXPECT_TRUE(belt.send(std::string("\0\1\0\5\0\6\1\3\x80\0\0\1", 12)));
    EXPECT_TRUE(belt.send(std::string("\0\2\0\0\0\6\1\3\x12\x34\0\1", 12)));
    const auto deadline = TcpSocket::Clock::now() + std::chrono::seconds(30);
    EXPECT_FALSE(belt.receive(deadline).empty());
    CellClient cell(daemon.port("grpc"));
    v1::LoadStateRequest load;
    load.set_name("none");
    v1::LoadStateResponse response;
    grpc::ClientContext context;
    EXPECT_FALSE(cell.control->LoadState(&context, load, &response).ok());
    EXPECT_EQ(daemon.stop(SIGTERM).exit_code, 0);
  }
  const auto all = read();
  const auto crcl = wires_of(all, "crcl.fanuc");
  ASSERT_EQ(contents(crcl), "orc");
  EXPECT_NE(crcl[2].text(), "");
  const auto modbus = wires_of(all, "modbus");
  ASSERT_EQ(contents(modbus), "orrsc");
  EXPECT_NE(modbus[1].text(), "");
  EXPECT_EQ(modbus[2].text(), "");
  EXPECT_EQ(static_cast<std::uint8_t>(modbus[3].data().at(7)), 0x83);
  const auto grpc = wires_of(all, "grpc");
  ASSERT_EQ(contents(grpc), "orsc");
  EXPECT_NE(grpc[2].text().find("none"), std::string::npos) << grpc[2].text();
}

}  // namespace
}  // namespace aprsim::test
