#pragma once

#include "clients/aprsim/scenario/measures.hpp"
#include "world/scenario/scenario.hpp"

/// Published rules of NIST's Agile Robotics for Industrial Automation Competition (ARIAC), mapped
/// to this cell, and our own figures of agility.
namespace aprsim::client {

/// ARIAC 2024, kitting task (pages.nist.gov/ARIAC_docs, scoring). The right tray counts 1, another
/// one -1. A slot counts 3 with the right part, 0 with a wrong, flipped or faulty one. If all parts
/// are right, the number of parts less the surplus is added. A kit at a wrong destination scores 0;
/// no score is negative. Kits of an order with priority are weighted by `priority`.
[[nodiscard]] double kit_score(const KitResult& kit, const scenario::Scoring& scoring);
/// The maximum score of the kit.
[[nodiscard]] double best_score(const KitResult& kit, const scenario::Scoring& scoring);

/// ARIAC 2025, penalties. A collision of a robot costs `collision`, and as much for every
/// `collision_again_s` of its duration; between two robots it costs twice that. A part on an
/// invalid surface costs `invalid_surface`: a grasped part that ends in no slot and no gripper.
[[nodiscard]] double penalty(const Measured& measured, const scenario::Scoring& scoring);

/// Adds score, score_share, efficiency, penalty and agility to the values.
///   efficiency  ARIAC 2024's: time of a baseline run over own time
///   agility     ours, after the idea of Downs et al. (2021, "Assessing Industrial Robot Agility
///               Through International Competitions"): performance under faults, as score over
///               time, relative to that of the baseline run without faults
void add_scores(Measured& measured, const scenario::Scoring& scoring);

}  // namespace aprsim::client
