#pragma once

#include <string>

#include "clients/ros2/dds/action_server.hpp"
#include "clients/ros2/simulation/step_goals.hpp"

namespace aprsim::ros2 {

/// The action simulation_interfaces/action/SimulateSteps. Thread: one. Errors of DDS:
/// std::runtime_error.
class StepsServer {
 public:
  /// `ros_namespace`: before the name of the action, empty = none.
  StepsServer(Node& node, const std::string& ros_namespace, const Wakeup& wakeup);

  /// Whether there are steps to take.
  [[nodiscard]] bool is_active() const { return goals_.is_active(); }
  /// Answers the requests that have come, takes the next steps and publishes what they led to;
  /// without a simulation goals fail. `now`: simulated time.
  void serve(Simulation* simulation, const google::protobuf::Duration& now);

 private:
  void write_progress(const StepProgress& progress) const;

  ActionServer action_;
  StepGoals goals_;
};

}  // namespace aprsim::ros2
