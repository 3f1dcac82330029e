#include "protocols/crcl/program_runner.hpp"

#include <utility>
#include <variant>

#include "crcl/program_loops.hpp"

namespace aprsim::crcl_server {

Result<ProgramRunner> ProgramRunner::of_document(crcl::Program program, Caller caller) {
  crcl::Result<std::vector<std::size_t>> order = crcl::expand_loops(program);
  if (!order) {
    return fail(ErrorCode::kInvalidArgument, order.error().element, order.error().message());
  }
  ProgramRunner runner;
  runner.file_ = program.name.value_or("CRCLProgram");
  runner.program_ = std::move(program);
  runner.order_ = std::move(*order);
  runner.caller_ = std::move(caller);
  return runner;
}

Result<ProgramRunner> ProgramRunner::of_command(crcl::Program program, std::int64_t id,
                                                Caller caller) {
  Result<ProgramRunner> runner = of_document(std::move(program), std::move(caller));
  if (!runner) return runner;
  runner->fixed_id_ = id;
  std::erase_if(runner->order_, [&](std::size_t i) {
    const crcl::CommandBody& body = runner->program_.commands[i].body;
    return std::holds_alternative<crcl::InitCanon>(body) ||
           std::holds_alternative<crcl::EndCanon>(body);
  });
  return runner;
}

crcl::CommandInstance ProgramRunner::next() {
  const std::size_t index = order_[next_++];
  crcl::CommandInstance instance;
  instance.command = program_.commands[index];
  if (fixed_id_) instance.command.id = *fixed_id_;
  instance.program_file = file_;
  instance.program_index = static_cast<int>(index);
  instance.program_length = static_cast<int>(program_.commands.size());
  pending_.reset();
  return instance;
}

}  // namespace aprsim::crcl_server
