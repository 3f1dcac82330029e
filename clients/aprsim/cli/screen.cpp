#include "clients/aprsim/cli/screen.hpp"

#include <cstdlib>
#include <string_view>
#include <unistd.h>

namespace aprsim::client {
namespace {

std::string_view variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

bool is_capable_terminal(int fd) {
  const std::string_view kind = variable("TERM");
  return isatty(fd) == 1 && !kind.empty() && kind != "dumb";
}

}  // namespace

Screen Screen::of_process() {
  // https://no-color.org: present and not empty, whatever its value.
  const bool colours = variable("NO_COLOR").empty();
  const bool live = is_capable_terminal(STDOUT_FILENO);
  return {.live = live,
          .out = Paint(colours && live),
          .err = Paint(colours && is_capable_terminal(STDERR_FILENO))};
}

}  // namespace aprsim::client
