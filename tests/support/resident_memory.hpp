#pragma once

#include <fstream>
#include <stdexcept>
#include <string>
#include <sys/types.h>

namespace aprsim::test {

/// Resident memory of a process [MB]. Throws std::runtime_error when the process has ended.
inline double resident_mb(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmRSS:")) return std::stod(line.substr(6)) / 1024;
  }
  throw std::runtime_error("the process has ended");
}

}  // namespace aprsim::test
