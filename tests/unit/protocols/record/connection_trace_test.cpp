#include "protocols/record/connection_trace.hpp"

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
  void record(WireRecord record) override { records.push_back(std::move(record)); }
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
    // A moved trace continues.
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

TEST(WireTrace, RecordsARequestBehindItsImmediateAnswer) {
  test::FakeCell cell;
  Kept kept;
  const auto at_step = [&](std::uint64_t step) {
    cell.publish([step](api::Snapshot& snapshot) { snapshot.step = step; });
  };
  ConnectionTrace trace(&kept, cell, WireKind::kCrcl, "crcl.fanuc", "a");
  at_step(10);
  trace.received_first("question");
  EXPECT_EQ(kept.contents(), "o");
  at_step(20);
  trace.sent("answer");
  ASSERT_EQ(kept.contents(), "ors");
  EXPECT_EQ(kept.records[1].data, "question");
  EXPECT_EQ(kept.records[1].step, 10U);
  EXPECT_EQ(kept.records[2].step, 20U);
  EXPECT_LE(kept.records[1].wall, kept.records[2].wall);
  trace.catch_up();
  EXPECT_EQ(kept.contents(), "ors");

  // A command without an answer is published on request, before the next one and at the end.
  trace.received_first("command");
  trace.catch_up();
  EXPECT_EQ(kept.contents(), "orsr");
  trace.received_first("command");
  trace.received_first("command");
  EXPECT_EQ(kept.contents(), "orsrr");
  trace.closed("by the client");
  trace.catch_up();
  EXPECT_EQ(kept.contents(), "orsrrrc");
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
