#include <utility>

#include <spdlog/spdlog.h>

#include "crcl/decoder.hpp"
#include "crcl/text.hpp"
#include "protocols/crcl/command_lifecycle.hpp"

namespace aprsim::protocols {
namespace {

// A program of settings alone must not keep the others waiting.
constexpr int kStepsPerTurn = 64;

}  // namespace

void CommandLifecycle::execute(crcl::Program program,
                               const std::shared_ptr<ConnectionSettings>& settings,
                               const std::string& peer) {
  refresh(*source_.latest());
  program_.reset();
  const std::int64_t id = program.commands.empty() ? 0 : program.commands.front().id;
  Result<ProgramRunner> run = ProgramRunner::of_document(std::move(program), settings, peer);
  if (!run) return refuse("CRCLProgram", id, run.error().message);
  spdlog::info("{}: program from {}", name_, peer);
  start(std::move(*run));
}

void CommandLifecycle::run_text(const crcl::RunProgram& command,
                                const std::shared_ptr<ConnectionSettings>& settings,
                                const std::string& peer) {
  if (in_program_) return latch_error("RunProgram within a program is not supported.");
  const auto program = crcl::decode_program(command.text, options_.max_program_bytes);
  if (!program && program.error().kind != crcl::ErrorKind::kBadValue) {
    return latch_error("RunProgram runs a CRCLProgram document only; the text begins with \"" +
                       crcl::shorten(crcl::trim(command.text), 40) + "\".");
  }
  if (!program) return latch_error("RunProgram: " + program.error().message());
  crcl::CommandInstance caller;
  caller.command.id = latest_.command_id;
  Result<ProgramRunner> run = ProgramRunner::of_command(*program, caller, settings, peer);
  if (!run) return latch_error("RunProgram: " + run.error().message);
  done();
  if (!run->finished()) start(std::move(*run));
}

void CommandLifecycle::start(ProgramRunner run) {
  program_ = std::move(run);
  advance();
  if (program_ && wake_) wake_();
}

void CommandLifecycle::advance() {
  const api::SnapshotPtr snapshot = source_.latest();
  refresh(*snapshot);
  for (int i = 0; i < kStepsPerTurn && program_; ++i) {
    if (!step_done(*snapshot)) return;
    if (program_->finished()) return program_.reset();
    const crcl::CommandInstance instance = program_->take();
    if (std::holds_alternative<crcl::GetStatus>(instance.command.body)) continue;
    // Kept alive beyond the program, which the command may end.
    const std::shared_ptr<ConnectionSettings> settings = program_->settings();
    const std::string peer = program_->peer();
    in_program_ = true;
    carry_out(instance, settings, peer);
    if (error_) return program_.reset();
    const bool waiting = progress_ == Progress::kWaiting;
    program_->step = waiting ? ProgramRunner::Step{ticket_, setting_} : ProgramRunner::Step{};
  }
}

bool CommandLifecycle::step_done(const api::Snapshot& snapshot) {
  const ProgramRunner::Step step = program_->step;
  if (step.ticket == 0) return true;
  if (error_) {
    program_.reset();
    return false;
  }
  if (step.setting) return snapshot.applied >= step.ticket;
  const api::RobotSnapshot& robot = snapshot.robots[static_cast<std::size_t>(robot_)];
  if (robot.action.ticket < step.ticket) return false;
  if (robot.action.ticket == step.ticket) return robot.action.state == api::ActionState::kDone;
  // A setting of ours that another socket sent meanwhile has taken the command's place in the
  // report, not on the robot.
  if (robot.action.ticket == last_setting_) return !robot.moving;
  program_.reset();
  latch_error("The program was interrupted by a command from another interface.");
  return false;
}

}  // namespace aprsim::protocols
