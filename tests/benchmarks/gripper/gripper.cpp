// Fig. 3 of the paper: what a gear does in a floating gripper that accelerates, by gripper law; and
// from which acceleration on friction lets it go.

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/benchmarks/gripper/floating_grip.hpp"
#include "tests/benchmarks/support/experiment.hpp"

namespace aprsim::bench {
namespace {

using Eigen::Vector3d;

const std::vector<GripperLawCase> kLaws = {
    {"constant", scene::GripperLaw::kConstant},
    {"mimic_p", scene::GripperLaw::kMimicPid, false},
    {"mimic_pid", scene::GripperLaw::kMimicPid},
    {"coupled", scene::GripperLaw::kCoupled},
    {"linkage", scene::GripperLaw::kLinkage},
    {"linkage_v", scene::GripperLaw::kLinkage, true, scene::PadShape::kV}};

struct Way {
  const char* name;
  Vector3d direction;
};
const std::vector<Way> kWays = {{"x", {1, 0, 0}},    {"y", {0, 1, 0}},   {"-y", {0, -1, 0}},
                                {"z", {0, 0, 1}},    {"-z", {0, 0, -1}}, {"xyz", {1, 1, 1}},
                                {"x-yz", {1, -2, 1}}};

struct Worst {
  double delta_m = 0, theta_rad = 0;
  int drops = 0;
  void add(const Shake& shake) {
    delta_m = std::max(delta_m, shake.delta_m);
    theta_rad = std::max(theta_rad, shake.theta_rad);
    drops += shake.dropped;
  }
};

bool along_fingers(const Way& way) { return way.direction.y() != 0; }

using ByLaw = std::map<std::string, std::pair<Worst, Worst>>;  // in x and z only; with y

ByLaw sweep(Experiment& experiment) {
  const std::vector<double> accels = experiment.quick()
                                         ? std::vector<double>{0.5, 30}
                                         : std::vector<double>{0.5, 1, 2, 5, 10, 20, 30};
  const std::vector<std::string> gears = experiment.quick()
                                             ? std::vector<std::string>{"small"}
                                             : std::vector<std::string>{"small", "medium", "large"};
  Table all({"law", "gear", "direction", "accel_m_s2", "delta_m", "theta_rad", "dropped"});
  ByLaw worst;
  Plot plot{.title = "Largest displacement in the hand, along the fingers",
            .x = {.label = "acceleration [m/s2]", .log = true},
            .y = {.label = "delta_t [m]", .log = true, .floor = 1e-12}};
  for (const GripperLawCase& law : kLaws) {
    Series series{law.name, {}};
    for (const double accel : accels) {
      double along = 0;
      for (const std::string& gear : gears) {
        for (const Way& way : kWays) {
          const Shake run =
              shake({.law = law, .gear = gear, .direction_T = way.direction, .accel_m_s2 = accel});
          (along_fingers(way) ? worst[law.name].second : worst[law.name].first).add(run);
          if (along_fingers(way)) along = std::max(along, run.delta_m);
          all.row({law.name, gear, std::string(way.name), accel, run.delta_m, run.theta_rad,
                   run.dropped ? 1.0 : 0.0});
        }
      }
      series.points.emplace_back(accel, along);
    }
    plot.series.push_back(series);
  }
  experiment.table("sweep", "", all);
  experiment.plot("sweep", plot);
  return worst;
}

void over_time(Experiment& experiment) {
  Plot delta{.title = "30 m/s2 along the fingers, medium gear: displacement in the hand",
             .x = {.label = "t [s]"},
             .y = {.label = "delta_t [m]", .log = true, .floor = 1e-12}};
  Plot theta{.title = "30 m/s2 along the fingers, medium gear: rotation in the hand",
             .x = {.label = "t [s]"},
             .y = {.label = "theta_t [rad]", .log = true, .floor = 1e-12}};
  Table table({"law", "t_s", "delta_m", "theta_rad"});
  for (const GripperLawCase& law : kLaws) {
    const Shake run = shake({.law = law, .gear = "medium", .accel_m_s2 = 30});
    Series of_delta{law.name, {}}, of_theta{law.name, {}};
    for (std::size_t i = 0; i < run.delta_over_time_m.size(); ++i) {
      const double t = 1e-3 * static_cast<double>(i + 1);
      of_delta.points.emplace_back(t, run.delta_over_time_m[i]);
      of_theta.points.emplace_back(t, run.theta_over_time_rad[i]);
      table.row({law.name, t, run.delta_over_time_m[i], run.theta_over_time_rad[i]});
    }
    delta.series.push_back(of_delta);
    theta.series.push_back(of_theta);
  }
  experiment.table("over_time", "", table);
  experiment.plot("delta_over_time", delta);
  experiment.plot("theta_over_time", theta);
}

/// Weak fingers, so that the limit is within reach: up, where nothing but friction counts.
int thresholds(Experiment& experiment) {
  const std::vector<double> shares =
      experiment.quick() ? std::vector<double>{0.98, 1.02}
                         : std::vector<double>{0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 1.01, 1.02, 1.1};
  Table table({"law", "gear", "limit_m_s2", "accel_over_limit", "slip_m", "slips"});
  int false_drops = 0, missed = 0;
  for (const GripperLawCase& law : kLaws) {
    for (const char* gear : {"small", "medium", "large"}) {
      for (const double share : shares) {
        ShakeCase c{.law = law, .gear = gear, .force_n = 0.8, .pad_friction = 0.6};
        const double limit = drop_limit_up(c);
        c.direction_T = -Vector3d::UnitZ();  // the tool points down
        c.accel_m_s2 = share * limit;
        const Shake run = shake(c);
        // Beyond the limit the gear falls behind by the difference of the accelerations.
        const double behind = 0.5 * std::max(0.0, share - 1) * limit * c.duration_s * c.duration_s;
        const bool slips = run.delta_m > std::max(1e-4, 0.5 * behind);
        const bool shipped = law.law == scene::GripperLaw::kLinkage;
        false_drops += shipped && slips && share < 1;
        missed += shipped && !slips && share > 1;
        table.row({law.name, std::string(gear), limit, share, run.delta_m, slips ? 1.0 : 0.0});
      }
    }
  }
  experiment.table("thresholds", "", table);
  experiment.record("gripper.missed_drops", missed, "count");
  return false_drops;
}

int run(int argc, char** argv) {
  Experiment experiment("gripper", argc, argv);
  const ByLaw worst = sweep(experiment);
  Table table({"law", "delta_xz_m", "delta_y_m", "theta_rad", "drops"});
  for (const GripperLawCase& law : kLaws) {
    const auto& [xz, y] = worst.at(law.name);
    const double theta = std::max(xz.theta_rad, y.theta_rad);
    table.row({law.name, xz.delta_m, y.delta_m, theta, static_cast<double>(xz.drops + y.drops)});
    experiment.record("gripper." + law.name + ".delta_xz_m", xz.delta_m, "m");
    experiment.record("gripper." + law.name + ".delta_y_m", y.delta_m, "m");
    experiment.record("gripper." + law.name + ".theta_rad", theta, "rad");
    experiment.record("gripper." + law.name + ".drops", xz.drops + y.drops, "count");
  }
  experiment.table("laws", "Largest motion of a gear in the hand, 0.5 to 30 m/s2", table);
  Worst shipped;
  for (const char* law : {"linkage", "linkage_v"}) {
    for (const Worst& w : {worst.at(law).first, worst.at(law).second}) {
      shipped.delta_m = std::max(shipped.delta_m, w.delta_m);
      shipped.theta_rad = std::max(shipped.theta_rad, w.theta_rad);
      shipped.drops += w.drops;
    }
  }
  experiment.record("gripper.default.delta_m", shipped.delta_m, "m");
  experiment.record("gripper.default.theta_rad", shipped.theta_rad, "rad");
  over_time(experiment);
  experiment.record("gripper.false_drops", shipped.drops + thresholds(experiment), "count");
  experiment.note(
      "Fc 60 N, pad friction 1, three gears, seven directions (tool frame: fingers "
      "along y, approach along z), constant acceleration for 0.1 s. delta_xz: "
      "directions without a part along the fingers; delta_y: all others. linkage_v: "
      "V pads, the others flat.");
  experiment.note("Thresholds: Fc 0.8 N, pad friction 0.6, upwards; limit 2 mu Fc / m - g.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
