#include "server/journal/frame_ring.hpp"

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace aprsim::server::journal {
namespace {

Frame frame(const std::string& bytes, std::uint64_t clock, bool begins = false) {
  return {.bytes = std::make_shared<const std::string>(bytes), .begins = begins, .clock = clock};
}

std::string joined(const std::vector<FrameBytes>& frames) {
  std::string all;
  for (const FrameBytes& bytes : frames) all += *bytes;
  return all;
}

TEST(FrameRing, GivesWhatIsAskedForFromABeginningOn) {
  FrameRing ring(1000, 1000);
  ring.add(frame("A", 0, true));
  ring.add(frame("b", 50));
  ring.add(frame("C", 100, true));
  ring.add(frame("d", 150));
  ring.add(frame("E", 200, true));
  EXPECT_EQ(joined(ring.last(10, 250)), "E");
  EXPECT_EQ(joined(ring.last(50, 250)), "E");
  EXPECT_EQ(joined(ring.last(51, 250)), "CdE");
  EXPECT_EQ(joined(ring.last(150, 250)), "CdE");
  EXPECT_EQ(joined(ring.last(100'000, 250)), "AbCdE");
  EXPECT_EQ(ring.bytes(), 5U);
}

TEST(FrameRing, KeepsAsMuchTimeAsItIsTold) {
  FrameRing ring(200, 1000);
  ring.add(frame("A", 0, true));
  ring.add(frame("B", 100, true));
  ring.add(frame("C", 200, true));
  // B alone makes 200 steps from here on.
  ring.add(frame("d", 299));
  EXPECT_EQ(joined(ring.last(1000, 299)), "ABCd");
  ring.add(frame("e", 300));
  EXPECT_EQ(joined(ring.last(1000, 300)), "BCde");
}

TEST(FrameRing, CountsDroppedFramesUntilTheirReadersAreDone) {
  FrameRing ring(1000, 10);
  ring.add(frame("AAAA", 0, true));
  std::vector<FrameBytes> read = ring.last(1000, 0);
  ring.add(frame("BBBB", 1, true));
  ring.add(frame("CCCC", 2, true));
  // A is dropped and still held, so that B has no room either.
  EXPECT_EQ(joined(ring.last(1000, 2)), "CCCC");
  EXPECT_EQ(ring.bytes(), 8U);
  read.clear();
  EXPECT_EQ(ring.bytes(), 4U);
  ring.add(frame("DDDD", 3, true));
  EXPECT_EQ(joined(ring.last(1000, 3)), "CCCCDDDD");
}

TEST(FrameRing, TakesNoMoreMemoryThanItMay) {
  FrameRing ring(1000, 10);
  ring.add(frame("AAAA", 0, true));
  ring.add(frame("BBBB", 1, true));
  EXPECT_TRUE(ring.wants_beginning());  // more than an eighth behind the last one
  ring.add(frame("cccc", 2));
  EXPECT_EQ(joined(ring.last(1000, 2)), "BBBBcccc");
  ring.add(frame("dddd", 3));
  EXPECT_EQ(joined(ring.last(1000, 3)), "");
  EXPECT_EQ(ring.bytes(), 0U);
  EXPECT_TRUE(ring.wants_beginning());
  // Nothing can be run of what has no beginning.
  ring.add(frame("e", 4));
  EXPECT_EQ(joined(ring.last(1000, 4)), "");
  ring.add(frame("F", 5, true));
  EXPECT_EQ(joined(ring.last(1000, 5)), "F");
  EXPECT_FALSE(ring.wants_beginning());
}

TEST(FrameRing, KeepsNothingWithoutSize) {
  FrameRing ring(1000, 0);
  ring.add(frame("A", 0, true));
  EXPECT_EQ(joined(ring.last(1, 0)), "");
  EXPECT_FALSE(ring.wants_beginning());
}

}  // namespace
}  // namespace aprsim::server::journal
