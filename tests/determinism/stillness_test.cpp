// Clients compare poses to 1e-4 mm: an arm at rest must not move by one bit.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>

#include <gtest/gtest.h>

#include "world/cell/world.hpp"
#include "world/scene/scene_loader.hpp"

namespace aprsim::world {
namespace {

template <typename Vector>
bool same_bits(const Vector& a, const Vector& b) {
  return std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  });
}

bool same_bits(const Pose& a, const Pose& b) {
  return same_bits(a.p, b.p) && same_bits(a.q.coeffs(), b.q.coeffs());
}

TEST(Stillness, TheReportedToolPoseKeepsEveryBitForTenMinutes) {
  auto loaded = scene::load_scene("aprs", scene::default_data_paths());
  ASSERT_TRUE(loaded) << loaded.error().message;
  World world(std::make_shared<const scene::Scene>(std::move(*loaded)), 1);
  api::Snapshot start, now;
  world.apply(1, api::RobotCommand{0, api::InitRobot{}});
  world.apply(2, api::RobotCommand{0, api::MoveJoints{{{.joint = 0, .position_rad = 0.2}}}});
  for (int step = 0; step < 5000; ++step) world.step();
  world.write(start);
  ASSERT_EQ(start.robots[0].action.state, api::ActionState::kDone);
  ASSERT_NEAR(start.robots[0].joints[0].position_rad, 0.2, 1e-12);
  constexpr int kSteps = 600'000;
  for (int step = 0; step < kSteps; ++step) {
    world.step();
    if (step % 1000 != 0) continue;
    world.write(now);
    for (std::size_t robot = 0; robot < now.robots.size(); ++robot) {
      ASSERT_TRUE(same_bits(now.robots[robot].X_RT, start.robots[robot].X_RT)) << step;
      ASSERT_TRUE(same_bits(now.robots[robot].X_WT, start.robots[robot].X_WT)) << step;
    }
  }
}

}  // namespace
}  // namespace aprsim::world
