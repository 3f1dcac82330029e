#include "world/robot/controller/command_progress.hpp"

namespace aprsim::robot {
namespace {

constexpr std::size_t kDescriptionCapacity = 512;

}  // namespace

CommandProgress::CommandProgress() {
  // Steps must not allocate, so descriptions keep their capacity.
  status_.description.reserve(kDescriptionCapacity);
  description_.reserve(kDescriptionCapacity);
}

void CommandProgress::accept(api::Ticket ticket, api::ActionKind kind) {
  status_.ticket = ticket;
  status_.kind = kind;
}

void CommandProgress::begin(Task task) {
  task_ = task;
  description_.clear();
  if (!in_error()) wait();
}

void CommandProgress::wait() {
  status_.state = api::ActionState::kWorking;
  status_.description.clear();
}

void CommandProgress::complete(const char* description) {
  task_ = Task::kNone;
  // An error that is held hides the completion: the command that set it has failed.
  if (in_error()) return;
  status_.state = api::ActionState::kDone;
  if (description != nullptr) {
    status_.description.assign(description);
  } else {
    status_.description = description_;
  }
}

void CommandProgress::set_description(const std::string& description) {
  description_.assign(description, 0, kDescriptionCapacity);
}

void CommandProgress::set_error(const std::string& reason) {
  held_error_ = reason;
  initialized_ = false;
  task_ = Task::kNone;
  // CRCL: an error is held until the robot is initialised again, whatever commands follow.
  status_.state = api::ActionState::kError;
  status_.description = reason;
}

void CommandProgress::initialize() {
  held_error_.clear();
  initialized_ = true;
}

}  // namespace aprsim::robot
