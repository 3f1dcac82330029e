#pragma once

#include "world/physics/arm_penalty.hpp"
#include "world/physics/contact_search.hpp"
#include "world/physics/physics_model.hpp"
#include "world/physics/physics_world.hpp"
#include "world/physics/step_solver.hpp"

namespace aprsim::physics {

struct PhysicsWorld::Impl {
  Impl(const scene::Scene& scene, std::span<const robot::ArmModel> models,
       std::span<const std::vector<Eigen::Isometry3d>> X_WL)
      : cell(scene, models, X_WL), finder(cell), solver(cell), arm_contacts(cell) {
    forces.resize(cell.arms.size());
    for (auto& list : forces) list.reserve(256);
    released.reserve(cell.bodies.size());
    for (const auto& links : X_WL) next_mounts.push_back(links.back());
  }

  void step();
  void solve();
  void move_arms();
  void take_results();
  void count_faults();
  void report_touch(const ContactConstraint& touch);
  [[nodiscard]] bool in_hand(int robot, BodyIndex node) const;
  void observe_grippers();

  PhysicsModel cell;
  ContactSearch finder;
  StepSolver solver;
  ArmPenalty arm_contacts;
  std::vector<std::vector<ArmForce>> forces;
  std::vector<int> released;
  std::vector<Eigen::Isometry3d> next_mounts;  ///< of the grippers; set before every step
  double next_belt_speed = 0;
  std::uint64_t steps = 0, faults = 0;
  double max_penetration = 0;
  int contacts = 0;  // of the last step
};

}  // namespace aprsim::physics
