#include "tests/benchmarks/spin/rebound.hpp"

#include <algorithm>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::bench {
namespace {

constexpr int kMostSteps = 3000;
constexpr double kTouch = 1e-4;  // lower than this it has struck [m]

scene::Scene scene_of(scene::Simplification mode, Faller faller, double e, double height_m,
                      double yaw) {
  using namespace physics::test;
  scene::Scene scene = empty_scene();
  scene.physics.simplification = mode;
  auto& restitution = scene.physics.restitution;
  restitution.tray_ground = restitution.tray_belt = restitution.gear_ground = e;
  faller == Faller::kTrayOnBelt ? add_belt(scene) : add_table(scene);
  if (faller == Faller::kGearOnTable) {
    Pose pose;
    pose.p.z() = scene.gear_types.at("large").hub_height_m + height_m;
    pose.q = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
    add_gear(scene, "body", "large", pose);
  } else {
    add_tray(scene, "body", "small4", {0, 0}, {}, yaw);
    scene.trays.back().X_WP.p.z() += height_m;
  }
  return scene;
}

}  // namespace

const char* name_of(Faller faller) {
  switch (faller) {
    case Faller::kTrayOnTable:
      return "tray on table";
    case Faller::kTrayOnBelt:
      return "tray on belt";
    case Faller::kGearOnTable:
      return "gear on table";
  }
  return "";
}

double rebound(scene::Simplification mode, Faller faller, double restitution, double height_m,
               double yaw_rad) {
  physics::test::Bench bench(scene_of(mode, faller, restitution, height_m, yaw_rad));
  const double ground = bench.X_WB("body").translation().z() - height_m;
  double before = height_m, top = 0;
  bool struck = false;
  for (int step = 0; step < kMostSteps; ++step) {
    bench.run(1);
    const double now = bench.X_WB("body").translation().z() - ground;
    struck = struck || now >= before || now < kTouch;
    if (struck) top = std::max(top, now);
    // From the top of its first rise on it only falls again.
    if (struck && now < before && top > kTouch) break;
    before = now;
  }
  return top / height_m;
}

}  // namespace aprsim::bench
