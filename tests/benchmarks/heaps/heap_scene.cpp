#include "tests/benchmarks/heaps/heap_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::bench {
namespace {

constexpr std::array kGears = {"d50", "d60", "small", "medium"};
constexpr std::array kTrays = {"small4", "d604"};
constexpr int kTrayEvery = 4;                     // of a mixed heap
constexpr double kGearPitch = 0.1;                // [m], more than a medium gear's diameter
constexpr double kTrayPitch = 0.25;               // [m], more than a tray's diagonal
constexpr double kWall = 0.1, kWallHeight = 2.0;  // [m]

/// Numbers in [0, 1) that every standard library makes alike.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double operator()() { return static_cast<double>(engine_()) / 4294967296.0; }
  /// Any attitude, each as likely as every other one (Shoemake 1992).
  Eigen::Quaterniond attitude() {
    const double u = (*this)(), a = 2 * M_PI * (*this)(), b = 2 * M_PI * (*this)();
    return {std::sqrt(1 - u) * std::sin(a), std::sqrt(1 - u) * std::cos(a),
            std::sqrt(u) * std::sin(b), std::sqrt(u) * std::cos(b)};
  }

 private:
  std::mt19937 engine_;
};

void add_walls(scene::Scene& scene, double inner_m) {
  const double centre = 0.5 * (inner_m + kWall), length = inner_m + 2 * kWall;
  for (int side = 0; side < 4; ++side) {
    const bool along_x = side < 2;
    const double sign = side % 2 == 0 ? 1 : -1;
    Pose pose;
    pose.p = {along_x ? 0 : sign * centre, along_x ? sign * centre : 0, 0.5 * kWallHeight};
    const Eigen::Vector3d size = along_x ? Eigen::Vector3d(length, kWall, kWallHeight)
                                         : Eigen::Vector3d(kWall, length, kWallHeight);
    scene.fixed.push_back({"wall_" + std::to_string(side), size, pose});
  }
}

}  // namespace

std::string name_of(HeapParts parts) {
  if (parts == HeapParts::kGears) return "gears";
  return parts == HeapParts::kTrays ? "trays" : "mixed";
}

scene::Scene heap_scene(const HeapPlan& plan) {
  Random random(plan.seed);
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.simplification = scene::Simplification::kOff;
  physics::test::add_table(scene);
  const double pitch = plan.parts == HeapParts::kGears ? kGearPitch : kTrayPitch;
  // Twice as high as wide before it falls.
  const int columns = std::max(2, static_cast<int>(std::lround(std::cbrt(0.5 * plan.bodies))));
  if (plan.walls) add_walls(scene, columns * pitch);
  for (int i = 0; i < plan.bodies; ++i) {
    const int layer = i / (columns * columns), place = i % (columns * columns);
    const double middle = 0.5 * (columns - 1);
    Pose pose;
    pose.p =
        pitch * Eigen::Vector3d(place % columns - middle, place / columns - middle, layer + 0.7);
    pose.q = random.attitude();
    const auto number = static_cast<std::size_t>(i);
    const std::string name = "part_" + std::to_string(i);
    const bool tray =
        plan.parts == HeapParts::kTrays || (plan.parts == HeapParts::kMixed && i % kTrayEvery == 0);
    if (tray) {
      physics::test::add_tray(scene, name, kTrays[number / kTrayEvery % kTrays.size()], {0, 0}, {});
      scene.trays.back().X_WP = pose;
    } else {
      physics::test::add_gear(scene, name, kGears[number % kGears.size()], pose);
    }
  }
  return scene;
}

}  // namespace aprsim::bench
