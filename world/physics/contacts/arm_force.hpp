#pragma once

#include <Eigen/Core>

#include "world/api/snapshot/snapshot.hpp"

namespace aprsim::physics {

/// An external force on an arm, to be turned into joint torques by J^T.
struct ArmForce {
  int link = 0;  ///< index into ArmModel::links; the last one for the gripper
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d f_W = Eigen::Vector3d::Zero();  ///< [N]
  api::ContactSide partner;                       ///< the other side of the contact
  int partner_link = -1;                          ///< of the robot `partner`, where it is a link
  bool on_gripper = false;
  int part = -1;         ///< of the gripper: 0 palm, 1-2 fingers; -1 = none
  bool penalty = false;  ///< by ArmPenalty, not by the solver
  /// Force on the held body instead of the gripper, to report its contacts. It reaches the arm
  /// through the grip, whose forces are in the list as well, and so does not load the arm.
  bool relayed = false;

  /// See world/archive/archive.hpp.
  template <typename Self, typename Io>
  static void fields(Self& self, Io& io) {
    auto& [link, p_W, f_W, partner, partner_link, on_gripper, part, penalty, relayed] = self;
    io(link, p_W, f_W, partner, partner_link, on_gripper, part, penalty, relayed);
  }
  template <typename In>
  void require_valid(In& in) const {
    in.require(link >= 0 && partner_link >= -1 && part >= -1 && part < api::ContactSide::kFirstLink,
               "a force on an unknown part of a robot");
  }
};

}  // namespace aprsim::physics
