#include "protocols/wire_trace.hpp"

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/fake_cell.hpp"

namespace aprsim::protocols {
namespace {

class Kept final : public WireTrace {
 public:
  void note(WireRecord record) override { records.push_back(std::move(record)); }
  [[nodiscard]] std::string contents() const {
    std::string letters;
    for (const WireRecord& record : records) {
      letters += "orsc"[static_cast<std::size_t>(record.content)];
    }
    return letters;
  }
  std::vector<WireRecord> records;
};

TEST(WireTrace, TellsOfAConnectionFromItsOpeningToItsEnd) {
  test::FakeCell cell;
  Kept kept;
  {
    ConnectionTrace trace(&kept, cell, WireKind::kModbus, "modbus", "10.0.0.1:5");
    cell.publish([](api::Snapshot& snapshot) {
      snapshot.epoch = 3;
      snapshot.step = 2500;
      snapshot.time = std::chrono::milliseconds(2500);
    });
    trace.received(std::string("a\0b", 3), "wrong");
    trace.sent("answer");
    // Who takes it over goes on with it.
    ConnectionTrace moved(std::move(trace));
    moved.closed("by the client");
    moved.sent("too late");
  }
  ASSERT_EQ(kept.contents(), "orsc");
  const WireRecord& received = kept.records[1];
  EXPECT_EQ(received.data, std::string("a\0b", 3));
  EXPECT_EQ(received.text, "wrong");
  EXPECT_EQ(received.epoch, 3U);
  EXPECT_EQ(received.step, kept.records[2].step);
  EXPECT_EQ(received.sim_time, std::chrono::milliseconds(2500));
  EXPECT_EQ(received.connection->listener, "modbus");
  EXPECT_EQ(received.connection->peer, "10.0.0.1:5");
  EXPECT_EQ(kept.records[3].text, "by the client");
}

TEST(WireTrace, NumbersConnectionsOfAllListeners) {
  test::FakeCell cell;
  Kept kept;
  {
    const ConnectionTrace first(&kept, cell, WireKind::kCrcl, "crcl.fanuc", "a");
    const ConnectionTrace second(&kept, cell, WireKind::kVision, "vision.fanuc", "b");
    EXPECT_GT(first.number(), 0U);
    EXPECT_GT(second.number(), first.number());
  }
  EXPECT_EQ(kept.contents(), "oocc");
}

TEST(WireTrace, WhereNobodyTracesNothingIsTold) {
  test::FakeCell cell;
  ConnectionTrace trace(nullptr, cell, WireKind::kCrcl, "crcl.fanuc", "a");
  trace.received("x");
  trace.closed("y");
  EXPECT_EQ(trace.number(), 0U);
}

}  // namespace
}  // namespace aprsim::protocols
