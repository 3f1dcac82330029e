#include "world/runtime/publish/snapshot_slot.hpp"

#include <atomic>
#include <functional>
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

TEST(SnapshotSlot, WaitReturnsTheFirstSnapshotFromTheStepOn) {
  SnapshotSlot slot;
  publish(slot, 1);
  const auto seen = slot.latest();
  EXPECT_EQ(slot.wait_for_step(seen, 1, std::chrono::steady_clock::now() + 1ms), seen);
  publish(slot, 2);
  const auto second = slot.latest();
  EXPECT_EQ(slot.wait_for_step(seen, 3, std::chrono::steady_clock::now() + 1ms), second);
  std::jthread writer([&] {
    for (std::uint64_t step = 3; step < 1000; ++step) publish(slot, step);
  });
  EXPECT_GE(slot.wait_for_step(second, 500, std::chrono::steady_clock::now() + 10s)->step, 500U);
  writer.join();
  // Nor is it missed when the last to come is the one, or another epoch or a fault comes.
  EXPECT_EQ(slot.wait_for_step(second, 999, std::chrono::steady_clock::now() + 10s)->step, 999U);
  const auto last = slot.latest();
  const auto wakes_on = [&](const std::function<void(api::Snapshot&)>& change) {
    std::jthread changer([&] {
      auto next = slot.acquire();
      next->step = 0;
      next->epoch = last->epoch;
      change(*next);
      slot.publish(std::move(next));
    });
    return slot.wait_for_step(last, 2000, std::chrono::steady_clock::now() + 10s) != last;
  };
  EXPECT_TRUE(wakes_on([](api::Snapshot& next) { ++next.epoch; }));
  EXPECT_TRUE(wakes_on([](api::Snapshot& next) { next.world_fault = "broken"; }));
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
