#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "clients/aprsim/cli/interruption.hpp"
#include "clients/aprsim/run.hpp"

int main(int argc, char** argv) {
  using namespace aprsim::client;
  int exit_code = 1;
  try {
    interruption::install();
    exit_code = run(std::vector<std::string>(argv + 1, argv + argc), std::cout, std::cerr,
                    Screen::of_process());
  } catch (const std::exception& error) {
    std::cerr << "aprsim: " << error.what() << '\n';
  }
  return interruption::happened() ? interruption::leave() : exit_code;
}
