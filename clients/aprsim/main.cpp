#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "clients/aprsim/run.hpp"

int main(int argc, char** argv) {
  try {
    return aprsim::client::run(std::vector<std::string>(argv + 1, argv + argc), std::cout,
                               std::cerr);
  } catch (const std::exception& error) {
    std::cerr << "aprsim: " << error.what() << '\n';
    return 1;
  }
}
