#include "tests/benchmarks/kit100/kit_picking.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/benchmarks/support/clock.hpp"
#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using physics::test::Bench;

constexpr const char* kPart = "d50";
constexpr int kSide = 10;
constexpr double kPitch = 0.055, kMargin = 0.03;  // of the slots, and beside the outer ones [m]
constexpr double kKitAt = 0.75;                   // where the other kit is [m]
constexpr double kLift = 0.06, kPlaceHeight = 1e-4, kTipOverDisc = 3.5e-3;
constexpr double kMostOff = 1e-3;  // farther from its slot a part is not in it [m]

scene::TrayType kit_type() {
  scene::TrayType kit;
  kit.name = "kit";
  const double half = 0.5 * (kSide - 1) * kPitch + kMargin;
  kit.min_xy = {-half, -half};
  kit.max_xy = {half, half};
  kit.thickness_m = 0.015;
  kit.mass_kg = 2;
  for (int i = 0; i < kSide * kSide; ++i) {
    scene::Slot slot{.name = "s" + std::to_string(i), .gear_type = kPart};
    const int column = i % kSide, row = i / kSide;
    const double middle = 0.5 * (kSide - 1);
    slot.xy = kPitch * Eigen::Vector2d(column - middle, row - middle);
    slot.pocket = physics::test::pocket_for(kPart);
    kit.slots.push_back(slot);
  }
  return kit;
}

std::string part(int slot) { return "part" + std::to_string(slot); }

scene::Scene scene_of(scene::Simplification mode) {
  scene::Scene scene = physics::test::empty_scene();
  scene.physics.simplification = mode;
  scene.tray_types["kit"] = kit_type();
  physics::test::add_table(scene);
  std::vector<std::string> full;
  for (int i = 0; i < kSide * kSide; ++i) full.push_back("s" + std::to_string(i) + "=" + part(i));
  physics::test::add_tray(scene, "from", "kit", {0, 0}, full);
  physics::test::add_tray(scene, "to", "kit", {kKitAt, 0}, {});
  const double tip = 0.015 + scene.gear_types.at(kPart).disc_height_m + kTipOverDisc + kLift;
  physics::test::add_hand(scene, {0, 0, tip});
  return scene;
}

class Picker {
 public:
  explicit Picker(scene::Simplification mode) : bench_(scene_of(mode)) { rest(1, false); }

  /// The part of that slot into the same slot of the other kit.
  void move_part(int slot) {
    const Eigen::Vector2d xy = bench_.scene.tray_types.at("kit").slots[index(slot)].xy;
    const Vector3d in_slot(xy.x(), xy.y(), 0);
    const Vector3d above = bench_.X_WB(part(slot)).translation() - bench_.X_WT.translation();
    move({above.x(), above.y(), 0}, 0.4);
    move({0, 0, -kLift}, 0.15);
    grip(0);
    move({0, 0, kLift}, 0.25);
    const auto hand = bench_.world->gripper(0);
    const bool has = hand.holding && hand.held_body == bench_.index_of(part(slot));
    result_.picked += has;
    if (!has) return grip(1);
    const auto to_slot = [&] {
      return Vector3d(bench_.X_WB("to") * in_slot - bench_.X_WB(part(slot)).translation());
    };
    move({to_slot().x(), to_slot().y(), 0}, 0.5);
    move({0, 0, to_slot().z() + kPlaceHeight}, 0.35);
    grip(1);
    move({0, 0, kLift + 1e-2}, 0.15);
    // Back to the height of the approach.
    move({0, 0, start_z_ - bench_.X_WT.translation().z()}, 0.05);
    result_.placed += to_slot().norm() < kMostOff;
  }
  /// How far a part that lies in the kit has moved in it.
  void look_at(int slot) {
    const Eigen::Vector2d xy = bench_.scene.tray_types.at("kit").slots[index(slot)].xy;
    const Vector3d in_kit = (bench_.X_WB("from").inverse() * bench_.X_WB(part(slot))).translation();
    result_.moved_m = std::max(result_.moved_m, (in_kit - Vector3d(xy.x(), xy.y(), 0)).norm());
  }
  [[nodiscard]] KitPicking result() {
    result_.unsolved = bench_.world->solver_failures().not_converged;
    return result_;
  }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] double h() const { return bench_.scene.physics.step_s; }
  void step(const Isometry3d* X_WT, bool timed = true) {
    const double before = 1e6 * thread_cpu_s();
    X_WT ? bench_.step_tool(*X_WT) : bench_.run(1);
    if (timed) result_.step_us.push_back(1e6 * thread_cpu_s() - before);
    result_.deepest_m = std::max(result_.deepest_m, bench_.world->max_penetration_m());
  }
  void rest(double seconds, bool timed = true) {
    for (int i = 0; i < std::lround(seconds / h()); ++i) step(nullptr, timed);
  }
  void move(const Vector3d& delta, double seconds) {
    const Isometry3d start = bench_.X_WT;
    const long count = std::lround(seconds / h());
    for (long i = 1; i <= count; ++i) {
      const double s = static_cast<double>(i) / static_cast<double>(count);
      Isometry3d next = start;
      next.translation() += s * s * s * (10 - 15 * s + 6 * s * s) * delta;
      step(&next);
    }
  }
  void grip(double setting) {
    bench_.world->set_gripper(0, setting);
    for (int i = 0; i < 500 && (i == 0 || !bench_.world->gripper(0).settled); ++i) step(nullptr);
    rest(0.05);
  }

  Bench bench_;
  double start_z_ = bench_.X_WT.translation().z();
  KitPicking result_;
};

}  // namespace

KitPicking pick_kit(scene::Simplification mode, int picks) {
  Picker picker(mode);
  // Every slot once, neighbours seldom after each other.
  constexpr int kStride = 37, kAll = kSide * kSide;
  for (int i = 0; i < picks; ++i) picker.move_part(kStride * i % kAll);
  for (int i = picks; i < kAll; ++i) picker.look_at(kStride * i % kAll);
  return picker.result();
}

}  // namespace aprsim::bench
