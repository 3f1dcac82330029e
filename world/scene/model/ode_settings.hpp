#pragma once

namespace aprsim::scene {

/// Settings of ODE as the engine of a scene. Gazebo's 50 iterations are too few for a grasp: pads
/// chatter by 5 N, and no gripper reports that it holds. With 200 they do not.
struct OdeSettings {
  enum class Stepper { kQuick, kDirect };  ///< dWorldQuickStep, dWorldStep

  Stepper stepper = Stepper::kQuick;
  int iterations = 200;     ///< of kQuick
  double erp = 0.2;         ///< share of a position error that a step corrects
  double cfm_m_s_n = 1e-6;  ///< velocity of joints and contacts per force
};

}  // namespace aprsim::scene
