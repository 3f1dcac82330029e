// Picking a peg gear out of a tray's pocket by friction and putting it into another one: the grid
// of grasp offsets, the same at fine steps, the insertion table and the cases that must fail.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/benchmarks/pick/pick_case.hpp"
#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/statistics.hpp"

namespace aprsim::bench {
namespace {

const std::vector<double> kOffsets = {-2e-3, -1e-3, -5e-4, 0, 5e-4, 1e-3, 2e-3};
const std::vector<double> kFewOffsets = {-2e-3, 5e-4};
const std::vector<double> kYaws = {0, std::numbers::pi / 4};
const std::vector<double> kTippingYaws = {0, std::numbers::pi / 8, std::numbers::pi / 4,
                                          std::numbers::pi / 2};

/// The worst of a set of runs.
struct Worst {
  int runs = 0, picked = 0, placed = 0;
  double slip_m = 0, slip_rad = 0, pop_m = 0, hop_m = 0, place_error_m = 0, centring_m = 0;
  double penetration_m = 0;
  std::vector<double> merged_us;

  void add(const PickResult& r) { add(r, 1); }
  void add(const Worst& w) { add(w, w.runs); }

 private:
  template <typename Result>
  void add(const Result& r, int runs_of_it) {
    runs += runs_of_it;
    picked += r.picked;
    placed += r.placed;
    slip_m = std::max(slip_m, r.slip_m);
    slip_rad = std::max(slip_rad, r.slip_rad);
    pop_m = std::max(pop_m, r.pop_m);
    hop_m = std::max(hop_m, r.hop_m);
    place_error_m = std::max(place_error_m, r.place_error_m);
    centring_m = std::max(centring_m, r.centring_m);
    penetration_m = std::max(penetration_m, r.penetration_m);
    merged_us.insert(merged_us.end(), r.merged_us.begin(), r.merged_us.end());
  }
};

const std::vector<std::string> kColumns = {
    "gear",           "mu",           "case",         "runs",       "picked",         "placed",
    "slip_um",        "slip_rad",     "pop_um",       "hop_um",     "place_error_um", "centring_um",
    "penetration_um", "step_mean_us", "step_p999_us", "step_max_us"};

void add_row(Table& table, const std::string& gear, double mu, const std::string& what,
             const Worst& w) {
  const bool timed = !w.merged_us.empty();
  table.row({gear, mu, what, double(w.runs), double(w.picked), double(w.placed), 1e6 * w.slip_m,
             w.slip_rad, 1e6 * w.pop_m, 1e6 * w.hop_m, 1e6 * w.place_error_m, 1e6 * w.centring_m,
             1e6 * w.penetration_m, timed ? mean(w.merged_us) : 0.0,
             timed ? percentile(w.merged_us, 0.999) : 0.0,
             timed ? percentile(w.merged_us, 1) : 0.0});
}

Worst over_offsets(PickCase c, const std::vector<double>& offsets, Table* each = nullptr) {
  Worst worst;
  for (const double yaw : kYaws) {
    for (const double across : offsets) {
      for (const double along : offsets) {
        c.yaw = yaw;
        c.off = {across, along};
        const PickResult r = run_pick(c);
        worst.add(r);
        if (!each) continue;
        each->row({c.gear, c.mu, yaw, 1e3 * across, 1e3 * along, double(r.picked), double(r.placed),
                   1e6 * r.slip_m, r.slip_rad, 1e6 * r.pop_m, 1e6 * r.hop_m, 1e6 * r.place_error_m,
                   1e6 * r.penetration_m});
      }
    }
  }
  return worst;
}

void grid(Experiment& experiment) {
  const bool quick = experiment.quick();
  const std::vector<std::string> gears =
      quick ? std::vector<std::string>{"d70"} : std::vector<std::string>{"d50", "d70", "d100"};
  Table table(kColumns);
  Table each({"gear", "mu", "yaw_rad", "across_mm", "along_mm", "picked", "placed", "slip_um",
              "slip_rad", "pop_um", "hop_um", "place_error_um", "penetration_um"});
  Worst all;
  for (const std::string& gear : gears) {
    for (const double mu : {0.4, 1.0}) {
      const Worst w = over_offsets({.gear = gear, .mu = mu}, quick ? kFewOffsets : kOffsets, &each);
      add_row(table, gear, mu, "flat pads", w);
      all.add(w);
    }
  }
  experiment.table("grid", "Grid of grasp offsets, worst of each", table);
  experiment.table("grid_each", "", each);
  experiment.record(
      {"pick.success", double(all.placed), "count", "runs", double(all.placed) / all.runs});
  experiment.record("pick.slip_m", all.slip_m, "m");
  experiment.record("pick.slip_rad", all.slip_rad, "rad");
  experiment.record("pick.pop_m", all.pop_m, "m");
  experiment.record("pick.hop_m", all.hop_m, "m");
  experiment.record("pick.place_error_m", all.place_error_m, "m");
  experiment.record("pick.step_mean_us", mean(all.merged_us), "us");
  experiment.record("pick.step_p999_us", percentile(all.merged_us, 0.999), "us");
  experiment.record("pick.step_max_us", percentile(all.merged_us, 1), "us");
}

/// The same at a quarter of the step, V pads, and the gripper law of eq. 1-2.
void variants(Experiment& experiment) {
  Table table(kColumns);
  const std::vector<double> offsets =
      experiment.quick() ? kFewOffsets : std::vector<double>{-1e-3, 0, 5e-4, 2e-3};
  for (const double mu : {0.4, 1.0}) {
    const PickCase base{.gear = "d70", .mu = mu};
    PickCase fine = base, v = base, coupled = base;
    fine.step_s = 2.5e-4;
    v.pad = scene::PadShape::kV;
    coupled.law = scene::GripperLaw::kCoupled;
    add_row(table, "d70", mu, "flat pads", over_offsets(base, offsets));
    add_row(table, "d70", mu, "step 0.25 ms (reference)", over_offsets(fine, offsets));
    const Worst centred = over_offsets(v, offsets);
    add_row(table, "d70", mu, "V pads", centred);
    add_row(table, "d70", mu, "eq. 1-2", over_offsets(coupled, offsets));
    if (mu == 0.4) experiment.record("pick.v_centring_m", centred.centring_m, "m");
  }
  experiment.table("variants", "Reference at a fine step, and other grippers", table);
}

/// The worst of the grid again, with shorter steps, slower fingers and a stiff mount: a finger that
/// has pushed the gear's hub against its pocket kicks the hand, whose mount yields upwards and
/// takes the gear along.
void pops(Experiment& experiment) {
  struct Hand {
    double finger_m_s, palm_n_m;
    std::string record;
  };
  const std::vector<Hand> hands = {{0.3, 5e3, "pick.pop_fine_steps_m"},
                                   {0.05, 5e3, "pick.pop_fine_steps_slow_fingers_m"},
                                   {0.3, 1e6, "pick.pop_fine_steps_stiff_mount_m"}};
  const std::vector<double> steps =
      experiment.quick() ? std::vector<double>{1e-3} : std::vector<double>{1e-3, 5e-4, 2.5e-4};
  Table table({"finger_m_s", "palm_n_m", "mu", "step_ms", "pop_um"});
  for (const Hand& hand : hands) {
    double fine = 0;
    for (const double mu : {0.4, 1.0}) {
      for (const double step : steps) {
        double pop = 0;
        for (const double along : {-2e-3, 2e-3}) {
          const PickCase c{.gear = "d50",
                           .mu = mu,
                           .off = {0, along},
                           .palm_stiffness_n_m = hand.palm_n_m,
                           .finger_speed_m_s = hand.finger_m_s,
                           .step_s = step};
          pop = std::max(pop, run_pick(c).pop_m);
        }
        table.row({hand.finger_m_s, hand.palm_n_m, mu, 1e3 * step, 1e6 * pop});
        if (step == steps.back()) fine = std::max(fine, pop);
      }
    }
    experiment.record(hand.record, fine, "m");
  }
  experiment.table("pops", "Pop of the lightest gear over hand and step", table);
}

/// Radius up to which all lateral errors end in the slot.
void insertion(Experiment& experiment) {
  const std::vector<double> across = {0, 2.5e-4, 5e-4, 1e-3, 2e-3}, along = {0, 5e-4, 1e-3};
  Table table({"palm_n_m", "chamfer_mm", "mu", "capture_mm", "clearance_and_chamfers_mm", "placed",
               "slip_um", "step_max_us"});
  Plot plot{.title = "Capture radius over palm stiffness",
            .x = {.label = "palm stiffness [N/m]", .log = true},
            .y = {.label = "capture radius [mm]"}};
  double least_margin = 1;
  for (const double chamfer : {0.0, 5e-4, 1.5e-3}) {
    Series series{"chamfer " + number_text(1e3 * chamfer) + " mm", {}};
    for (const double palm : {2e3, 5e3, 1e4, 1e6}) {
      if (experiment.quick() && (palm != 5e3 || chamfer != 5e-4)) continue;
      double missed = 1, capture = 0, slip = 0, step = 0;
      int placed = 0;
      std::vector<std::pair<double, bool>> runs;
      for (const double x : across) {
        for (const double y : along) {
          const PickResult r = run_pick({.gear = "d70",
                                         .mu = 0.6,
                                         .place_off = {x, y},
                                         .palm_stiffness_n_m = palm,
                                         .pocket_clearance_m = 2e-4,
                                         .pocket_chamfer_m = chamfer});
          runs.emplace_back(std::hypot(x, y), r.placed);
          if (!r.placed) missed = std::min(missed, std::hypot(x, y));
          placed += r.placed;
          slip = std::max(slip, r.slip_m);
          for (const double us : r.merged_us) step = std::max(step, us);
        }
      }
      for (const auto& [radius, ok] : runs) {
        if (ok && radius < missed - 1e-9) capture = std::max(capture, radius);
      }
      const double lead_in = 2e-4 + chamfer + 3e-4;
      if (palm <= 1e4) least_margin = std::min(least_margin, missed - lead_in);
      table.row({palm, 1e3 * chamfer, 0.6, 1e3 * capture, 1e3 * lead_in, double(placed), 1e6 * slip,
                 step});
      series.points.emplace_back(palm, 1e3 * capture);
    }
    plot.series.push_back(series);
  }
  experiment.table("insertion", "Insertion with lateral errors, 15 each", table);
  experiment.plot("insertion", plot);
  experiment.record("pick.capture_margin_m", least_margin, "m");
}

/// Off-centre closes with ever less friction: from a moment balance the gear must tip below about
/// mu = 0.34, and must not above it.
void tipping(Experiment& experiment) {
  Table table({"mu", "pop_um"});
  Series series{"d70", {}};
  for (const double mu : {0.2, 0.25, 0.3, 0.35, 0.4, 0.6}) {
    Worst w;
    for (const double yaw : experiment.quick() ? std::vector<double>{0} : kTippingYaws) {
      for (const double along : {-1e-3, 2e-3}) {
        w.add(run_pick({.gear = "d50", .mu = mu, .off = {0, along}, .yaw = yaw}));
      }
    }
    table.row({mu, 1e6 * w.pop_m});
    series.points.emplace_back(mu, 1e6 * w.pop_m);
    if (mu == 0.3) experiment.record("pick.tipping_pop_mu03_m", w.pop_m, "m");
    if (mu == 0.4) experiment.record("pick.tipping_pop_mu04_m", w.pop_m, "m");
  }
  experiment.table("tipping", "Tipping threshold", table);
  experiment.plot("tipping", {.title = "Pop of the gear at an off-centre close",
                              .x = {.label = "friction coefficient"},
                              .y = {.label = "pop [um]"},
                              .series = {series}});
}

/// Placings far off with a rigid palm press the hub onto the rim: none may count as placed.
void rigid_palm(Experiment& experiment) {
  int counted = 0, reported = 0, runs = 0;
  double force = 0;
  for (const double x : {1.5e-3, 2e-3, 3e-3}) {
    const PickResult r = run_pick({.gear = "d70",
                                   .mu = 0.6,
                                   .place_off = {x, 0},
                                   .palm_stiffness_n_m = 1e8,
                                   .pocket_clearance_m = 2e-4});
    ++runs;
    counted += r.placed;
    reported += !r.placed;
    force = std::max(force, r.penetration_m);
  }
  experiment.record({"pick.rigid_palm_misses_detected", double(reported), "count", "runs",
                     double(reported) / runs});
  experiment.record("pick.rigid_palm_penetration_m", force, "m");
}

int run(int argc, char** argv) {
  Experiment experiment("pick", argc, argv);
  grid(experiment);
  variants(experiment);
  pops(experiment);
  insertion(experiment);
  tipping(experiment);
  rigid_palm(experiment);
  experiment.note(
      "Gears 50/70/100 mm (10/20/33 g), hub 20 x 6 mm in a pocket with 0.3 mm of clearance, two "
      "2x2 "
      "trays, six neighbours, friction mu on every surface, 60 N, linkage law, palm 5 kN/m. Pop "
      "and "
      "hop: height above the nominal pose; placement error: horizontal, gear to slot, the target "
      "corrected for where the gear sits in the hand. A placing with a penetration over 0.5 mm "
      "anywhere never counts.");
  experiment.note(
      "step_us: CPU time of the steps of a single run in which hand, gear and tray are in touch, "
      "contact finding included.");
  experiment.note(
      "Pops: the lightest gear, grasped 2 mm off along the fingers' way, is lifted. One finger "
      "strikes it; its hub in the pocket drives the tray, and it tips about the hub as far as "
      "the pad yields upwards. Up to half of that is an error of the step. The rest comes from "
      "the hand, whose compliant mount yields to the impact: it almost vanishes with a stiff "
      "mount, "
      "and shrinks with slow fingers.");
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
