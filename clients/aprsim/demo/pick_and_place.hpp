#pragma once

#include <iosfwd>
#include <string>

#include "clients/aprsim/cell_connection.hpp"
#include "clients/aprsim/demo/arm.hpp"
#include "clients/aprsim/demo/cell_view.hpp"

namespace aprsim::client {

/// What the demo knows of the cell while it works.
struct DemoCell {
  CellConnection& connection;
  const v1::CellDescription& description;
  std::ostream& out;

  [[nodiscard]] Outcome<CellView> look() const;
};

/// Takes a gear by its peg and puts it into a slot, with CRCL commands; gRPC only looks on. Then
/// checks from gRPC that it was carried by the gripper and rests in the slot within a millimetre.
/// kRefused before anything was gripped means: out of reach, try another transfer.
class PickAndPlace {
 public:
  PickAndPlace(DemoCell& cell, Arm& arm, Transfer transfer);
  [[nodiscard]] Outcome<void> run();
  /// True once the gripper has closed on something.
  [[nodiscard]] bool gripped() const { return gripped_; }

 private:
  [[nodiscard]] Outcome<void> reach_for_gear();
  [[nodiscard]] Outcome<void> pick();
  [[nodiscard]] Outcome<void> await_grip();
  [[nodiscard]] Outcome<void> lift();
  [[nodiscard]] Outcome<void> carry();
  [[nodiscard]] Outcome<void> place();
  [[nodiscard]] Outcome<void> check_place();

  [[nodiscard]] Outcome<void> approach(const Eigen::Vector3d& p_WT);
  [[nodiscard]] Outcome<Eigen::Isometry3d> gear_in_tool(const char* when) const;
  void say(const std::string& text) const;

  DemoCell& cell_;
  Arm& arm_;
  const Transfer transfer_;
  double yaw_rad_ = 0;
  std::vector<double> yaws_;
  Eigen::Vector3d p_grasp_WT_;
  Eigen::Isometry3d X_TP_;  // gear in the hand, measured
  bool gripped_ = false;
};

}  // namespace aprsim::client
