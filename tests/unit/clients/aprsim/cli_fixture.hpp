#pragma once

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "clients/aprsim/run.hpp"
#include "tests/unit/protocols/grpc/telemetry_fixture.hpp"

namespace aprsim::test {

struct CliResult {
  int exit_code = 0;
  std::string out, err;
};

inline CliResult run_cli(const std::vector<std::string>& arguments) {
  std::ostringstream out, err;
  const int exit_code = client::run(arguments, out, err);
  return {exit_code, out.str(), err.str()};
}

/// A file of the running test's own.
inline std::string write_file(const std::string& name, const std::string& content) {
  const std::string path = testing::TempDir() + "aprsim_" +
                           testing::UnitTest::GetInstance()->current_test_info()->name() + "_" +
                           name;
  std::ofstream(path) << content;
  return path;
}

}  // namespace aprsim::test
