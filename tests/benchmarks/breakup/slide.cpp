#include "tests/benchmarks/breakup/slide.hpp"

#include <cmath>

#include "tests/benchmarks/trays/tray_run.hpp"
#include "world/physics/physics_world.hpp"

namespace aprsim::bench {
namespace {

constexpr double kSteadySpeed = 0.1, kRamp = 0.2;  // [m/s], [m/s2]
constexpr const char* kTrayType = "sku_small_gear_vessel";
constexpr const char* kGearType = "sku_part_small_gear";

Pose on_belt(const scene::Scene& scene, double z_m) {
  const Eigen::Isometry3d X_WC = scene.conveyor->X_WC.isometry();
  return Pose::from(X_WC * Eigen::Translation3d(-0.8, 0, z_m));
}

void add_gear(scene::Scene& scene, const Eigen::Vector3d& p_PG) {
  auto& tray = scene.trays.back();
  Pose X_WG = tray.X_WP;
  X_WG.p += tray.X_WP.q * p_PG;
  scene.gears.push_back(
      {.name = "gear_" + std::to_string(scene.gears.size()), .type = kGearType, .X_WP = X_WG});
}

void fill(scene::Scene& scene, std::size_t count) {
  const auto& slots = scene.tray_types.at(kTrayType).slots;
  for (std::size_t i = 0; i < count; ++i) {
    add_gear(scene, {slots[i].xy.x(), slots[i].xy.y(), 0});
    scene.trays.back().gears[slots[i].name] = scene.gears.back().name;
  }
}

scene::Scene scene_of(const SlideCase& slide) {
  scene::Scene scene = bare_belt(slide.mode);
  scene.conveyor->X_WC.q = Eigen::AngleAxisd(slide.heading_rad, Eigen::Vector3d::UnitZ()) *
                           Eigen::AngleAxisd(-slide.tilt_rad, Eigen::Vector3d::UnitY());
  const bool tray_slides = slide.slider == Slider::kTray || slide.slider == Slider::kLoadedTray;
  scene.physics.friction.tray_belt = tray_slides ? slide.friction : 2.0;
  scene.physics.friction.gear_tray = tray_slides ? 1.0 : slide.friction;
  scene::TrayType slab = scene.tray_types.at(kTrayType);
  slab.name = "slab";
  slab.slots.clear();
  scene.tray_types["slab"] = slab;
  const bool flat = slide.slider == Slider::kGear;
  scene.trays.push_back({.name = "tray",
                         .type = flat ? "slab" : kTrayType,
                         .X_WP = on_belt(scene, slab.thickness_m)});
  // Forward of the middle: it slides back by half the tray's length.
  if (flat) add_gear(scene, {0.04, 0, scene.gear_types.at(kGearType).hub_height_m});
  if (slide.slider == Slider::kLoadedTray) fill(scene, 4);
  if (slide.slider == Slider::kGearInPocket) fill(scene, 1);
  return scene;
}

/// Watches one slider: where it is along the belt, and whether its parts are simplified together.
class Observer {
 public:
  Observer(const physics::PhysicsWorld& world, const scene::Scene& scene, Slider slider)
      : world_(world),
        axis_(scene.conveyor->X_WC.q * Eigen::Vector3d::UnitX()),
        gears_(static_cast<int>(scene.gears.size())),
        relative_(slider == Slider::kGear || slider == Slider::kGearInPocket) {}

  /// Along the belt: of the gear relative to its tray, or of the tray in the world.
  [[nodiscard]] double position() const {
    const double tray = axis_.dot(world_.body(0).p_WB);
    return relative_ ? axis_.dot(world_.body(1).p_WB) - tray : tray;
  }
  [[nodiscard]] int pairs() const {
    const auto tray = world_.body(0);
    int count = 0;
    for (int gear = 1; gear <= gears_; ++gear) {
      if (tray.group >= 0 && world_.body(gear).group == tray.group) ++count;
    }
    return count;
  }
  [[nodiscard]] bool relative() const { return relative_; }

 private:
  const physics::PhysicsWorld& world_;
  Eigen::Vector3d axis_;
  int gears_;
  bool relative_;
};

}  // namespace

const char* name_of(Slider slider) {
  switch (slider) {
    case Slider::kTray:
      return "tray";
    case Slider::kLoadedTray:
      return "loaded tray";
    case Slider::kGear:
      return "gear";
    case Slider::kGearInPocket:
      return "gear in pocket";
  }
  return "";
}

double limit_accel(const SlideCase& slide) {
  constexpr double kGravity = 9.81;
  return kGravity * (slide.friction * std::cos(slide.tilt_rad) - std::sin(slide.tilt_rad));
}

double closed_form_slip(const SlideCase& slide) {
  const double limit = limit_accel(slide), excess = slide.accel_m_s2 - limit;
  if (excess <= 0) return 0;
  const double lag_speed = excess * slide.accelerating_s;
  return 0.5 * lag_speed * slide.accelerating_s + lag_speed * lag_speed / (2 * limit);
}

SlideResult slide(const SlideCase& slide) {
  const scene::Scene scene = scene_of(slide);
  physics::PhysicsWorld world(scene, {}, {});
  const double h = scene.physics.step_s;
  const Observer observer(world, scene, slide.slider);
  double speed = 0, travel = 0;
  const auto run = [&](double seconds, double accel, const auto& each_step) {
    const int steps = static_cast<int>(std::lround(seconds / h));
    for (int step = 0; step < steps; ++step) {
      speed += accel * h;
      world.set_belt_speed(speed);
      world.step();
      travel += speed * h;
      each_step();
    }
  };
  const auto nothing = [] {};
  run(0.3, 0, nothing);
  run(kSteadySpeed / kRamp, kRamp, nothing);
  run(0.3, 0, nothing);
  const double start = observer.position();
  travel = 0;
  SlideResult result;
  int pairs = observer.pairs();
  const auto count_breaks = [&] {
    const int now = observer.pairs();
    if (now < pairs) result.breaks += pairs - now;
    pairs = now;
  };
  run(slide.accelerating_s, slide.accel_m_s2, count_breaks);
  const double limit = limit_accel(slide);
  const double lag_speed = std::max(0.0, slide.accel_m_s2 - limit) * slide.accelerating_s;
  run(lag_speed / limit + 0.05, 0, count_breaks);
  const double moved = observer.position() - start;
  result.slip_m = observer.relative() ? -moved : travel - moved;
  return result;
}

}  // namespace aprsim::bench
