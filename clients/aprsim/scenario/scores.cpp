#include "clients/aprsim/scenario/scores.hpp"

#include <algorithm>
#include <cmath>

namespace aprsim::client {
namespace {

double weight(const KitResult& kit, const scenario::Scoring& scoring) {
  return kit.priority > 0 ? scoring.priority : 1;
}

}  // namespace

double kit_score(const KitResult& kit, const scenario::Scoring& scoring) {
  if (!kit.submitted_s || !kit.at_destination) return 0;
  double score = kit.tray_right ? scoring.tray : -scoring.tray;
  score += scoring.slot * kit.right;
  if (kit.right == kit.ordered) score += kit.ordered;
  score -= kit.surplus;
  return weight(kit, scoring) * std::max(0.0, score);
}

double best_score(const KitResult& kit, const scenario::Scoring& scoring) {
  return weight(kit, scoring) * (scoring.tray + (scoring.slot + 1) * kit.ordered);
}

double penalty(const Measured& measured, const scenario::Scoring& scoring) {
  double sum = 0;
  for (const Collision& collision : measured.collisions) {
    const double again =
        std::floor((collision.end_s - collision.begin_s) / scoring.collision_again_s);
    sum += scoring.collision * (collision.two_robots ? 2 : 1) * (1 + again);
  }
  return sum + scoring.invalid_surface * measured.values.at("parts_lost");
}

void add_scores(Measured& measured, const scenario::Scoring& scoring) {
  double score = 0, best = 0;
  for (const KitResult& kit : measured.kits) {
    score += kit_score(kit, scoring);
    best += best_score(kit, scoring);
  }
  auto& values = measured.values;
  values["score"] = score;
  if (best > 0) values["score_share"] = score / best;
  values["penalty"] = penalty(measured, scoring);
  const double job_s = values.at("job_s");
  if (!scoring.baseline_s || job_s <= 0) return;
  values["efficiency"] = *scoring.baseline_s / job_s;
  if (scoring.baseline_score) {
    values["agility"] = score / job_s / (*scoring.baseline_score / *scoring.baseline_s);
  }
}

}  // namespace aprsim::client
