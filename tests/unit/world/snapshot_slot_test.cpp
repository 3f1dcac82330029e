#include "world/snapshot_slot.hpp"

#include <atomic>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace aprsim::world {
namespace {

using namespace std::chrono_literals;

void publish(SnapshotSlot& slot, std::uint64_t step) {
  auto snapshot = slot.acquire();
  snapshot->step = step;
  snapshot->bodies.resize(3);
  slot.publish(std::move(snapshot));
}

TEST(SnapshotSlot, IsNeverNull) {
  const SnapshotSlot slot;
  EXPECT_NE(slot.latest(), nullptr);
}

TEST(SnapshotSlot, AReaderKeepsItsSnapshotUnchanged) {
  SnapshotSlot slot;
  publish(slot, 1);
  const auto held = slot.latest();
  for (std::uint64_t step = 2; step < 100; ++step) publish(slot, step);
  EXPECT_EQ(held->step, 1U);
  EXPECT_EQ(slot.latest()->step, 99U);
}

TEST(SnapshotSlot, MemoryIsReused) {
  SnapshotSlot slot;
  publish(slot, 1);
  const auto* first = slot.latest().get();
  publish(slot, 2);
  publish(slot, 3);
  EXPECT_EQ(slot.latest().get(), first);
}

TEST(SnapshotSlot, WaitNewerTimesOutAndWakes) {
  SnapshotSlot slot;
  publish(slot, 1);
  const auto seen = slot.latest();
  EXPECT_EQ(slot.wait_newer(seen, std::chrono::steady_clock::now() + 1ms), seen);
  std::jthread writer([&] { publish(slot, 2); });
  EXPECT_EQ(slot.wait_newer(seen, std::chrono::steady_clock::now() + 10s)->step, 2U);
}

TEST(SnapshotSlot, SnapshotsMayOutliveTheSlot) {
  api::SnapshotPtr held;
  {
    SnapshotSlot slot;
    publish(slot, 5);
    held = slot.latest();
  }
  EXPECT_EQ(held->step, 5U);
}

TEST(SnapshotSlot, ConcurrentReadersSeeWholeSnapshotsInOrder) {
  SnapshotSlot slot;
  publish(slot, 1);
  std::atomic<bool> done = false;
  std::vector<std::jthread> readers;
  for (int i = 0; i < 3; ++i) {
    readers.emplace_back([&] {
      std::uint64_t last = 0;
      while (!done) {
        const auto snapshot = slot.latest();
        EXPECT_GE(snapshot->step, last);
        EXPECT_EQ(snapshot->bodies.size(), 3U);
        last = snapshot->step;
      }
    });
  }
  for (std::uint64_t step = 2; step < 20000; ++step) publish(slot, step);
  done = true;
}

}  // namespace
}  // namespace aprsim::world
