#pragma once

#include <string>
#include <vector>

#include "tests/benchmarks/awake/jolt_model.hpp"
#include "tests/support/temporary_directory.hpp"
#include "world/api/values/pose.hpp"
#include "world/base/process/child_process.hpp"

namespace aprsim::bench {

/// A way to run Jolt that was found on this machine.
struct JoltProgram {
  std::string name;  ///< "native" or "WASM"
  std::vector<std::string> command;
};
/// `native` if it was built (CMake variable APRSIM_JOLT), `WASM` if npm's jolt-physics is installed
/// (tests/benchmarks/run); what is missing is said on standard error.
std::vector<JoltProgram> jolt_programs();

/// A scene in Jolt, in a process of its own that says what its own thread spent on each step. Jolt
/// asks for instructions and flags of the compiler that must not reach our own code. Throws
/// std::runtime_error when it stops answering.
class JoltProcess {
 public:
  JoltProcess(const JoltProgram& program, const scene::Scene& scene, const JoltSettings& settings);

  /// Version, precision and instructions of the build.
  [[nodiscard]] const std::string& version() const { return version_; }
  /// A step for each speed of the belt; times of all but the last, in which contacts are looked at
  /// [us].
  std::vector<double> run(const std::vector<double>& belt_speeds);
  /// Number and greatest depth of Jolt's contact points in the last of these steps.
  [[nodiscard]] int contact_count() const { return contacts_; }
  [[nodiscard]] double deepest_m() const { return deepest_m_; }
  /// Poses of body frames, trays first, then gears.
  [[nodiscard]] std::vector<Pose> poses();

 private:
  nlohmann::json answer();

  test::TemporaryDirectory directory_;
  nlohmann::json model_;
  process::ChildProcess child_;
  std::string version_;
  int contacts_ = 0;
  double deepest_m_ = 0;
};

}  // namespace aprsim::bench
