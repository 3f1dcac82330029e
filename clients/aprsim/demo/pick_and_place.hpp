#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "clients/aprsim/demo/arm.hpp"
#include "clients/aprsim/demo/cell_view.hpp"
#include "clients/aprsim/demo/demo_cell.hpp"
#include "clients/aprsim/demo/reach.hpp"

namespace aprsim::client {

/// Picks a gear by its peg and places it in a slot, with CRCL commands. Then checks over gRPC
/// that the gripper carried it and that it rests in the slot within a millimetre. A gear whose
/// slot is out of reach is returned to its place.
class PickAndPlace {
 public:
  PickAndPlace(DemoCell& cell, Arm& arm, Transfer transfer);
  [[nodiscard]] Outcome<void> run();
  /// After a failed run: the slot that the robot refused to go to, with everything as it was
  /// before; absent when it failed for another reason.
  [[nodiscard]] const std::optional<Refusal>& refusal() const { return refusal_; }

 private:
  [[nodiscard]] Outcome<void> reach_for_gear();
  [[nodiscard]] Outcome<void> pick();
  [[nodiscard]] Outcome<void> await_grip();
  [[nodiscard]] Outcome<void> lift();
  [[nodiscard]] Outcome<void> carry_and_place();
  [[nodiscard]] Outcome<void> carry();
  [[nodiscard]] Outcome<void> put_back(const Failure& reason);
  [[nodiscard]] Outcome<void> place(const SlotView& slot);
  [[nodiscard]] Outcome<void> check_place(const SlotView& slot);

  [[nodiscard]] Outcome<void> approach(const Eigen::Vector3d& p_WT);
  [[nodiscard]] Outcome<void> move_level(const Eigen::Isometry3d& X_WT);
  [[nodiscard]] Outcome<Eigen::Isometry3d> gear_in_tool(const char* when) const;
  void say(const char* event, const std::string& text, nlohmann::ordered_json fields) const;

  DemoCell& cell_;
  Arm& arm_;
  const Transfer transfer_;
  double yaw_rad_ = 0;
  std::vector<double> yaws_;
  Eigen::Vector3d p_grasp_WT_;
  Eigen::Isometry3d X_TP_;  // gear in the hand, measured
  std::optional<Refusal> refusal_;
};

}  // namespace aprsim::client
