#include "world/history/bookmark_maker.hpp"

#include <array>
#include <new>
#include <variant>

namespace aprsim::world {
namespace {

/// In the order of api::RobotAction.
constexpr std::array kActions{"made ready",          "end of session", "stop",           "move",
                              "move through points", "screw motion",   "move of joints", "gripper",
                              "gripper's force",     "tool changer",   "speed override", "dwell",
                              "motion limit"};
static_assert(kActions.size() == std::variant_size_v<api::RobotAction>);

}  // namespace

void BookmarkMaker::applied(RunTime time, const QueuedCommand& command, const Error* failure) {
  const std::string what = text_of(command.command);
  if (failure != nullptr) {
    note(time, api::BookmarkKind::kRefusal, what + " refused: " + failure->message);
  } else if (!std::holds_alternative<api::SimulationCommand>(command.command.body)) {
    note(time, api::BookmarkKind::kCommand, what);
  }
}

void BookmarkMaker::stopped(RunTime time, const std::string& why) {
  note(time, api::BookmarkKind::kStopped, "the simulation stopped: " + why);
}

void BookmarkMaker::note(RunTime time, api::BookmarkKind kind, const std::string& text) {
  try {
    bookmarks_.note({time.epoch, time.step}, kind, text);
  } catch (const std::bad_alloc&) {
    // The moment is there without it.
  }
}

std::string BookmarkMaker::text_of(const api::Command& command) const {
  if (const auto* robot = std::get_if<api::RobotCommand>(&command.body)) {
    const auto index = static_cast<std::size_t>(robot->robot);
    const std::string name = index < robots_.size() ? robots_[index] : "robot";
    return name + ": " + kActions[robot->action.index()];
  }
  if (std::holds_alternative<api::ConveyorCommand>(command.body)) return "belt: command";
  if (const auto* intruder = std::get_if<api::SetIntruder>(&command.body)) {
    return intruder->intruder ? "intruder put" : "intruder removed";
  }
  if (std::holds_alternative<api::FaultCommand>(command.body)) return "fault command";
  return "command of the simulation";
}

}  // namespace aprsim::world
