#pragma once

#include "clients/aprsim/scenario/measures.hpp"
#include "world/scenario/scenario.hpp"

/// Published rules of NIST's Agile Robotics for Industrial Automation Competition (ARIAC), mapped
/// to this cell, and our own figures of agility.
namespace aprsim::client {

/// ARIAC 2024, kitting task (pages.nist.gov/ARIAC_docs, scoring): 1 for the right tray, -1 for
/// another; for each slot 3 for the right part, 0 for one of a wrong type, flipped or faulty; when
/// all parts are right as much again as there are parts, less the surplus; 0 at a wrong
/// destination; never below 0. Kits of an order with priority weigh `priority` times.
[[nodiscard]] double kit_score(const KitResult& kit, const scenario::Scoring& scoring);
/// The most that the kit could have.
[[nodiscard]] double best_score(const KitResult& kit, const scenario::Scoring& scoring);

/// ARIAC 2025, penalties: each collision of a robot `collision`, again for every
/// `collision_again_s` that it lasts, twice when both are robots; each part on an invalid surface
/// `invalid_surface`: here one that was taken and ends in no slot and no gripper.
[[nodiscard]] double penalty(const Measured& measured, const scenario::Scoring& scoring);

/// Adds score, score_share, efficiency, penalty and agility to the values.
///   efficiency  ARIAC 2024's: time of a baseline run over own time
///   agility     ours, after the idea of Downs et al. (2021, "Assessing Industrial Robot Agility
///               Through International Competitions"): performance under faults, as score over
///               time, relative to that of the baseline run without faults
void add_scores(Measured& measured, const scenario::Scoring& scoring);

}  // namespace aprsim::client
