#include "protocols/crcl/program_runner.hpp"

#include <utility>
#include <variant>

#include "crcl/program_loops.hpp"

namespace aprsim::protocols {

Result<ProgramRunner> ProgramRunner::of_document(crcl::Program program,
                                                 std::shared_ptr<ConnectionSettings> settings,
                                                 std::string peer) {
  crcl::Result<std::vector<std::size_t>> order = crcl::expand_loops(program);
  if (!order) {
    return fail(ErrorCode::kInvalidArgument, order.error().element, order.error().message());
  }
  ProgramRunner run;
  run.file_ = program.name.value_or("CRCLProgram");
  run.program_ = std::move(program);
  run.order_ = std::move(*order);
  run.settings_ = std::move(settings);
  run.peer_ = std::move(peer);
  return run;
}

Result<ProgramRunner> ProgramRunner::of_command(crcl::Program program,
                                                const crcl::CommandInstance& command,
                                                std::shared_ptr<ConnectionSettings> settings,
                                                std::string peer) {
  Result<ProgramRunner> run = of_document(std::move(program), std::move(settings), std::move(peer));
  if (!run) return run;
  run->fixed_id_ = command.command.id;
  std::erase_if(run->order_, [&](std::size_t i) {
    const crcl::CommandBody& body = run->program_.commands[i].body;
    return std::holds_alternative<crcl::InitCanon>(body) ||
           std::holds_alternative<crcl::EndCanon>(body);
  });
  return run;
}

crcl::CommandInstance ProgramRunner::take() {
  const std::size_t index = order_[next_++];
  crcl::CommandInstance instance;
  instance.command = program_.commands[index];
  if (fixed_id_) instance.command.id = *fixed_id_;
  instance.program_file = file_;
  instance.program_index = static_cast<int>(index);
  instance.program_length = static_cast<int>(program_.commands.size());
  step = {};
  return instance;
}

}  // namespace aprsim::protocols
