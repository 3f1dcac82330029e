#pragma once

#include "world/robot/controller/guard_monitor.hpp"
#include "world/robot/controller/robot_controller.hpp"

/// Reaction of a controller to the guards of its command. Thread: sim.
namespace aprsim::robot {

/// Checks the guards against the state at the end of the last step. One that triggers stops the
/// motion `delay` later.
void check_guards(GuardMonitor& guards, RobotController& controller,
                  const api::RobotSnapshot& robot, SimTime now, SimTime delay);

/// Ends the monitoring of a command that is over. An error if its trigger was required and not
/// seen. Called after the controller's step, so that such a command is never reported as done.
void finish_guards(GuardMonitor& guards, RobotController& controller, SimTime now);

}  // namespace aprsim::robot
