#include "clients/aprsim/trace/export_program.hpp"

#include <chrono>
#include <fstream>
#include <iterator>

#include "clients/aprsim/cli/interruption.hpp"
#include "world/base/process/child_process.hpp"

namespace aprsim::trace {

using client::failed;
using client::FailureKind;
using process::ChildProcess;

client::Outcome<int> run_program(const std::vector<std::string>& arguments,
                                 const std::string& log) {
  auto program =
      ChildProcess::start(arguments, {{"APRSIM_TOKEN", ""}}, log, ChildProcess::Pipes::kNone);
  if (!program) return failed(FailureKind::kUsage, program.error().message);
  while (!program->wait(std::chrono::milliseconds(50))) {
    if (client::interruption::requested()) return failed(FailureKind::kInterrupted, "interrupted");
  }
  return program->ended().value_or(-1);
}

std::string content_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace aprsim::trace
