#include "tests/unit/world/physics/jams.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "tests/unit/world/physics/cell_builder.hpp"

namespace aprsim::physics::test {
namespace {

using Eigen::Vector3d;

constexpr double kStopX = 0.3, kWallX = 0.3, kThick = 0.02;  // [m]
constexpr double kFingers = 0.007;                           // half of a pad's width [m]

/// Numbers from a seed, the same with every standard library.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double within(double most) { return most * (2 * fraction() - 1); }
  double fraction() { return double(engine_()) / 4294967296.0; }
  Eigen::Quaterniond turn() {
    // Shoemake 1992.
    const double u = fraction(), a = 2 * std::numbers::pi * fraction();
    const double b = 2 * std::numbers::pi * fraction();
    return {std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a),
            std::sqrt(1 - u) * std::cos(a), std::sqrt(u) * std::sin(b)};
  }

 private:
  std::mt19937 engine_;
};

void add_wall(scene::Scene& scene, const Vector3d& centre, const Vector3d& size) {
  Pose pose;
  pose.p = centre;
  scene.fixed.push_back({"wall" + std::to_string(scene.fixed.size()), size, pose});
}

/// A gear that stands on its hub.
void stand(scene::Scene& scene, const std::string& type, double x, double y) {
  Pose pose;
  pose.p = {x, y, scene.gear_types.at(type).hub_height_m};
  add_gear(scene, "g" + std::to_string(scene.gears.size()), type, pose);
}

/// Each slot of a new tray with a gear, or not.
void add_loaded(scene::Scene& scene, Random& random, const std::string& name,
                const Eigen::Vector2d& xy, double yaw_rad) {
  std::vector<std::string> slots;
  for (int i = 1; i <= 4; ++i) {
    if (random.fraction() < 0.25) continue;
    slots.push_back("s" + std::to_string(i) + "=" + name + std::to_string(i));
  }
  add_tray(scene, name, "small4", xy, slots, yaw_rad);
}

/// Closed fingers whose tips are 2 mm above the table.
void add_fingers(scene::Scene& scene, double x, double y, double heading_rad) {
  add_hand(scene, {x, y, 2e-3}, heading_rad);
}

scene::Scene scene_of(Jam jam, Random& random) {
  scene::Scene scene = empty_scene();
  switch (jam) {
    case Jam::kQueue:
      add_belt(scene);
      add_wall(scene, {kStopX, 0, 0.05}, {kThick, 0.5, 0.1});
      for (int i = 0; i < 3; ++i) {
        const double y = random.within(0.01), yaw = random.within(0.05);
        add_loaded(scene, random, std::string(1, char('a' + i)), {-0.2 * i, y}, yaw);
      }
      break;
    case Jam::kWedge: {
      add_table(scene);
      add_wall(scene, {kWallX, 0, 0.05}, {kThick, 0.5, 0.1});
      stand(scene, "medium", 0.2, 0);
      add_fingers(scene, 0.12, random.within(4e-3), 0);
      break;
    }
    case Jam::kCorner: {
      add_table(scene);
      add_wall(scene, {kWallX, 0, 0.05}, {kThick, 0.6, 0.1});
      add_wall(scene, {0, 0.3, 0.05}, {0.6, kThick, 0.1});
      const double y = 0.18 + random.within(0.01);
      add_loaded(scene, random, "a", {0.12, y}, random.within(0.1));
      add_fingers(scene, 0.12 - 0.12, y + random.within(0.03), 0);
      break;
    }
    case Jam::kCrowd:
      add_table(scene);
      for (int i = 0; i < 12; ++i) {
        const double x = 0.1 + 0.068 * (i / 4), y = 0.068 * (i % 4 - 1.5) + 0.034 * (i / 4 % 2);
        const double off_x = random.within(1.5e-3);
        stand(scene, "small", x + off_x, y + random.within(1.5e-3));
      }
      add_fingers(scene, 0, random.within(5e-3), random.within(0.3));
      break;
    case Jam::kPile:
      add_table(scene);
      for (const double side : {-1.0, 1.0}) {
        add_wall(scene, {0.11 * side, 0, 0.1}, {kThick, 0.24, 0.2});
        add_wall(scene, {0, 0.11 * side, 0.1}, {0.2, kThick, 0.2});
      }
      for (int i = 0; i < 6; ++i) {
        Pose pose;
        const double x = random.within(0.04), y = random.within(0.04);
        pose.p = {x, y, 0.06 + 0.08 * i};
        pose.q = random.turn();
        add_gear(scene, "g" + std::to_string(i), i % 2 == 0 ? "small" : "medium", pose);
      }
      break;
  }
  return scene;
}

/// One jam as it runs.
class Course {
 public:
  Course(Jam jam, scene::Simplification mode, unsigned seed, const JamChange& change)
      : random_(seed), bench_(made(jam, mode, change)) {
    wait(200);
    switch (jam) {
      case Jam::kQueue:
        belt(0.2);
        wait(3000);
        press();
        belt(-0.2);
        wait(500);
        belt(0);
        break;
      case Jam::kWedge:
        bench_.grip(0);
        // The fingers would be 2 mm in the gear: their mount gives way.
        push({kWallX - 0.5 * kThick - 0.08 - kFingers + 2e-3 - 0.12, 0, 0}, 0.6);
        wait(300);
        press();
        push({-0.05, 0, 0}, 0.4);
        break;
      case Jam::kCorner:
        bench_.grip(0);
        push({0.14, 0, 0}, 0.8);
        wait(200);
        press();
        push({-0.05, 0, 0}, 0.4);
        break;
      case Jam::kCrowd:
        bench_.grip(0);
        push({0.28, 0, 0}, 0.9);
        press();
        push({0, 0, 0.1}, 0.4);
        break;
      case Jam::kPile:
        wait(600);
        press();
        break;
    }
    wait(jam == Jam::kPile || jam == Jam::kCrowd ? 900 : 500);
  }

  JamOutcome outcome() {
    out_.left = poses();
    for (int i = 0; i < bench_.world->body_count(); ++i) {
      out_.resting.push_back(bench_.world->body(i).resting);
    }
    out_.unsolved = bench_.world->solver_failures().not_converged;
    return std::move(out_);
  }

 private:
  scene::Scene made(Jam jam, scene::Simplification mode, const JamChange& change) {
    scene::Scene scene = scene_of(jam, random_);
    scene.physics.simplification = mode;
    auto& mu = scene.physics.friction;
    for (double* one : {&mu.gear_tray, &mu.gear_gear, &mu.gear_ground, &mu.tray_ground,
                        &mu.tray_belt, &mu.tray_tray, &mu.robot}) {
      *one *= change.friction_share;
    }
    for (auto& robot : scene.robots) robot.gripper.pad_friction *= change.friction_share;
    // Each its own way: what is shifted together does the same.
    double nudge_m = change.nudge_m;
    for (auto& gear : scene.gears) {
      gear.X_WP.p.x() += nudge_m;
      gear.X_WP.p.y() -= nudge_m;
      nudge_m = -nudge_m;
    }
    return scene;
  }
  void look() { out_.deepest_m = std::max(out_.deepest_m, bench_.world->max_penetration_m()); }
  void wait(int steps) {
    for (int i = 0; i < steps; ++i) {
      bench_.run(1);
      look();
    }
  }
  /// At the belt's own acceleration.
  void belt(double speed) {
    const double from = speed_;
    const int count = static_cast<int>(std::lround(std::abs(speed - from) / 0.5e-3));
    for (int i = 1; i <= count; ++i) {
      speed_ = from + (speed - from) * i / count;
      bench_.world->set_belt_speed(speed_);
      wait(1);
    }
  }
  void push(const Vector3d& way, double seconds) {
    const Eigen::Isometry3d start = bench_.X_WT;
    const int count = static_cast<int>(std::lround(seconds * 1e3));
    for (int i = 1; i <= count; ++i) {
      const double s = double(i) / count;
      Eigen::Isometry3d next = start;
      next.translation() += s * s * s * (10 - 15 * s + 6 * s * s) * way;
      bench_.step_tool(next);
      look();
    }
  }
  void press() { out_.pressed = poses(); }
  [[nodiscard]] std::vector<Pose> poses() const {
    std::vector<Pose> out;
    for (int i = 0; i < bench_.world->body_count(); ++i) {
      const auto state = bench_.world->body(i);
      out.push_back({state.p_WB, state.q_WB});
    }
    return out;
  }

  Random random_;
  Bench bench_;
  double speed_ = 0;
  JamOutcome out_;
};

}  // namespace

std::string name_of(Jam jam) {
  switch (jam) {
    case Jam::kQueue:
      return "queue";
    case Jam::kWedge:
      return "wedge";
    case Jam::kCorner:
      return "corner";
    case Jam::kCrowd:
      return "crowd";
    case Jam::kPile:
      return "pile";
  }
  throw std::invalid_argument("no jam");
}

JamOutcome run_jam(Jam jam, scene::Simplification mode, unsigned seed, const JamChange& change) {
  return Course(jam, mode, seed, change).outcome();
}

double farthest_apart(const std::vector<Pose>& a, const std::vector<Pose>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, (a[i].p - b.at(i).p).norm());
  return most;
}

}  // namespace aprsim::physics::test
