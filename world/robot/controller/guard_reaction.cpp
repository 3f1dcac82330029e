#include "world/robot/controller/guard_reaction.hpp"

#include <cstdio>
#include <string>

namespace aprsim::robot {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

}  // namespace

void check_guards(GuardMonitor& guards, RobotController& controller,
                  const api::RobotSnapshot& robot, SimTime now, SimTime delay) {
  const auto triggered = guards.check(robot, now, delay);
  if (!triggered) return;
  const api::ActionStatus& status = controller.status();
  // A guard of a command that is over stops the motion but ends nothing.
  const bool current =
      status.ticket == guards.state().ticket && status.state == api::ActionState::kWorking;
  const api::Guard& guard = guards.guard(*triggered);
  const std::string why = "Guard " + guard.label + " triggered at " +
                          number(guards.state().trigger_value) + ", limit " + number(guard.value);
  // The stop is on the path, so that a guarded approach does not leave its line.
  controller.stop_by_guard(current, why);
  if (guard.error_on_trigger) controller.fail(why + "; send InitCanon to go on");
}

void finish_guards(GuardMonitor& guards, RobotController& controller, SimTime now) {
  if (guards.stopping() && !controller.moving()) guards.at_rest(now);
  if (!guards.active()) return;
  const api::ActionStatus& status = controller.status();
  if (status.state == api::ActionState::kError) return guards.end();
  if (controller.moving() || status.state != api::ActionState::kDone) return;
  guards.end();
  // A command that needed a trigger and ended without one has failed, although its motion is
  // complete.
  const api::Guard* missing = guards.missing_trigger();
  if (missing == nullptr) return;
  controller.fail("Guard " + missing->label + ": required trigger not seen, limit " +
                  number(missing->value) + "; send InitCanon to go on");
}

}  // namespace aprsim::robot
