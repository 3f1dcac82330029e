// Parts in the hands of the shipped cell's robots, led over CRCL: swings of the wrist, and picks
// with random tool paths.

#include <algorithm>
#include <random>
#include <stdexcept>
#include <vector>

#include <spdlog/spdlog.h>

#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/statistics.hpp"
#include "tests/benchmarks/wrist/crcl_arm.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kLift = 0.15;     // [m]
constexpr double kSwing = 0.6;     // [rad]
constexpr double kAside = 0.06;    // of a tool path, about the lifted pose [m]
constexpr double kSettling = 0.4;  // at rest before each look [s]
constexpr double kRelease = 3e-4;  // over the place of the grip [m]
constexpr int kFirst = 10;         // swings in which a part may settle

/// A robot with a part that it can pick.
struct Picker {
  const char* name;
  int robot;
  const char* part;
};
constexpr std::array kPickers = {Picker{"fanuc", 0, "part_medium_gear_1"},
                                 Picker{"motoman", 1, "part_large_gear_5"}};

Isometry3d raised(Isometry3d X, double height_m) {
  X.translation().z() += height_m;
  return X;
}

double distance(const Isometry3d& a, const Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}

class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Vector3d direction() {
    std::normal_distribution<double> normal;
    const double x = normal(engine_), y = normal(engine_);
    return Vector3d(x, y, normal(engine_)).normalized();
  }

 private:
  std::mt19937_64 engine_;
};

/// Takes the part and lifts it.
Isometry3d pick(CrclArm& arm) {
  arm.set_gripper(1);
  arm.set_speed(0.4, 2);
  const Isometry3d grip = arm.grip();
  arm.move(raised(grip, kLift), false);
  arm.set_speed(0.12, 2);
  arm.move(grip, true);
  arm.dwell(0.05);
  arm.set_gripper(0);
  arm.dwell(0.05);
  arm.move(raised(grip, kLift), true);
  arm.dwell(kSettling);
  return grip;
}

void put_back(CrclArm& arm, const Isometry3d& grip) {
  arm.set_speed(0.1, 2);
  arm.move(raised(grip, kRelease), true);
  arm.dwell(0.05);
  arm.set_gripper(1);
  arm.dwell(0.2);
  arm.move(raised(grip, kLift), true);
}

/// Looks compare places at the same pose.
void go_back(CrclArm& arm, const Isometry3d& over) {
  if (!arm.move(over, false)) throw std::runtime_error("the robot does not get back");
}

/// Swings of the wrist about any axis, there and back; the drift after each.
struct Swings {
  std::vector<double> drifts_m;
  int refused = 0;
  double first_m = 0, growth_m = 0;
};

Swings swing(const Picker& picker, int count) {
  CrclArm arm(picker.robot, picker.part);
  Dice dice(50);
  const Isometry3d over = raised(pick(arm), kLift);
  arm.set_speed(1, 6);
  const Isometry3d start = arm.place();
  Isometry3d settled = start;
  Swings out;
  for (int i = 1; i <= count; ++i) {
    const Isometry3d turned = over * Eigen::AngleAxisd(dice.between(0.2, kSwing), dice.direction());
    out.refused += arm.move(turned, false) ? 0 : 1;
    go_back(arm, over);
    arm.dwell(kSettling);
    out.drifts_m.push_back(distance(start, arm.place()));
    if (i == std::min(kFirst, count)) settled = arm.place();
  }
  if (!arm.holding()) throw std::runtime_error("the part was lost while the wrist swung");
  out.first_m = distance(start, settled);
  out.growth_m = distance(settled, arm.place());
  return out;
}

/// Picks with a random path before the part is put back; how far each has moved in the hand.
struct Picks {
  std::vector<double> drifts_m;
  int refused = 0, lost = 0;
};

Picks pick_often(const Picker& picker, int count) {
  CrclArm arm(picker.robot, picker.part);
  Dice dice(51);
  Picks out;
  for (int i = 0; i < count; ++i) {
    const Isometry3d grip = pick(arm);
    const Isometry3d over = raised(grip, kLift), start = arm.place();
    arm.set_speed(dice.between(0.2, 1), dice.between(1, 6));
    for (int leg = 0; leg < 3; ++leg) {
      Isometry3d aim = over * Eigen::AngleAxisd(dice.between(0, kSwing), dice.direction());
      aim.translation() += dice.between(0, kAside) * dice.direction();
      out.refused += arm.move(aim, dice.between(0, 1) < 0.5) ? 0 : 1;
    }
    go_back(arm, over);
    arm.dwell(kSettling);
    out.drifts_m.push_back(distance(start, arm.place()));
    out.lost += arm.holding() ? 0 : 1;
    put_back(arm, grip);
  }
  return out;
}

int run(int argc, char** argv) {
  spdlog::set_level(spdlog::level::warn);
  Experiment experiment("wrist", argc, argv);
  const int count = experiment.quick() ? 2 : 100;
  Table table({"robot", "what", "count", "refused moves", "median [m]", "greatest [m]",
               "after the last [m]", "lost"});
  Plot plot{.title = "Place of the part in the hand after swings of the wrist",
            .x = {.label = "swings"},
            .y = {.label = "drift [m]", .log = true, .floor = 1e-12}};
  double swung = 0, picked = 0, first = 0, growth = 0;
  int lost = 0;
  for (const Picker& picker : kPickers) {
    const Swings swings = swing(picker, count);
    table.row({picker.name, "swings, drift in all", double(count), double(swings.refused),
               percentile(swings.drifts_m, 0.5), percentile(swings.drifts_m, 1),
               swings.drifts_m.back(), 0.0});
    swung = std::max(swung, percentile(swings.drifts_m, 1));
    first = std::max(first, swings.first_m);
    growth = std::max(growth, swings.growth_m);
    Series series{.name = picker.name};
    for (std::size_t i = 0; i < swings.drifts_m.size(); ++i) {
      series.points.emplace_back(double(i + 1), swings.drifts_m[i]);
    }
    plot.series.push_back(std::move(series));
    const Picks picks = pick_often(picker, count);
    table.row({picker.name, "picks, drift of each", double(count), double(picks.refused),
               percentile(picks.drifts_m, 0.5), percentile(picks.drifts_m, 1),
               picks.drifts_m.back(), double(picks.lost)});
    picked = std::max(picked, percentile(picks.drifts_m, 1));
    lost += picks.lost;
  }
  experiment.table("wrist", "Place of the part in the hand, over CRCL", table);
  experiment.plot("swings", plot);
  experiment.record("wrist.swings.drift_m", swung, "m");
  experiment.record("wrist.swings.first_ten_m", first, "m");
  experiment.record("wrist.swings.growth_m", growth, "m");
  experiment.record("wrist.picks.drift_m", picked, "m");
  experiment.record("wrist.picks.lost", lost, "count");
  experiment.note(
      "The shipped cell behind its CRCL server, as fast as it goes. Each robot lifts a gear by "
      "150 mm. Swings: 0.2 to 0.6 rad about any axis through the tool tip and back, rotation limit "
      "6 rad/s; the drift is counted from the first. Picks: three poses up to 0.6 rad and 60 mm "
      "off, back, and the gear is put back. Places are compared after 0.4 s at rest, at the pose "
      "of "
      "the first look.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
