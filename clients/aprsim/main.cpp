#include <cerrno>
#include <exception>
#include <fcntl.h>
#include <iostream>
#include <string>
#include <unistd.h>
#include <vector>

#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/run.hpp"

namespace {

/// Takes the numbers of standard streams that are closed, which else a socket or a file would get:
/// the output would go there. Reading from and writing to what is opened here fails.
void occupy_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) >= 0 || errno != EBADF) continue;
    static_cast<void>(::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY));
  }
}

}  // namespace

int main(int argc, char** argv) {
  using namespace aprsim::client;
  occupy_closed_streams();
  int exit_code = 1;
  try {
    interruption::install();
    exit_code = run(std::vector<std::string>(argv + 1, argv + argc), std::cout, std::cerr,
                    Screen::of_process());
  } catch (const std::exception& error) {
    std::cerr << "aprsim: " << error.what() << '\n';
  }
  return interruption::happened() ? interruption::exit_process() : exit_code;
}
