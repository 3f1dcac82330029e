#include "clients/aprsim/cli/python_program.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <unistd.h>

#include "world/base/process/own_programs.hpp"

namespace aprsim::client {

Outcome<void> become_python(const std::vector<std::string>& words) {
  std::vector<std::string> line = {"python3", "-m"};
  line.insert(line.end(), words.begin(), words.end());
  std::vector<char*> arguments;
  for (std::string& word : line) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  if (const std::string package = process::python_packages(); !package.empty()) {
    const char* const other = std::getenv("PYTHONPATH");
    ::setenv("PYTHONPATH", (other != nullptr ? package + ":" + other : package).c_str(), 1);
  }
  ::execvp(arguments.front(), arguments.data());
  return failed(FailureKind::kUsage,
                "python3 cannot be started: " + std::string(std::strerror(errno)));
}

}  // namespace aprsim::client
