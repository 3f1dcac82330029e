#include "tests/benchmarks/awake/jolt_process.hpp"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <thread>

#include "world/base/process/own_programs.hpp"

namespace aprsim::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kAnswer = std::chrono::seconds(60);
constexpr auto kLook = std::chrono::microseconds(200);
const std::string kFolder = APRSIM_SOURCE_DIR "/tests/benchmarks/awake";

process::ChildProcess started(const JoltProgram& program, const std::string& model,
                              const std::string& log) {
  std::vector<std::string> arguments = program.command;
  arguments.push_back(model);
  auto child = process::ChildProcess::start(arguments, {}, log,
                                            process::ChildProcess::Pipes::kInputAndOutput);
  if (!child) throw std::runtime_error(child.error().message);
  return std::move(*child);
}

}  // namespace

std::vector<JoltProgram> jolt_programs() {
  std::vector<JoltProgram> out;
#ifdef APRSIM_JOLT_NATIVE
  out.push_back({"native", {process::program_beside("jolt_native")}});
#else
  std::fputs("No native Jolt: CMake's APRSIM_JOLT names none.\n", stderr);
#endif
  if (std::filesystem::exists(kFolder + "/node_modules/jolt-physics")) {
    // Compiled by the optimising compiler at once: no step pays for it.
    out.push_back({"WASM", {"node", "--no-liftoff", kFolder + "/jolt_wasm.mjs"}});
  } else {
    std::fprintf(stderr, "No Jolt in WASM: `npm ci` in %s brings it.\n", kFolder.c_str());
  }
  return out;
}

JoltProcess::JoltProcess(const JoltProgram& program, const scene::Scene& scene,
                         const JoltSettings& settings)
    : model_(jolt_model(scene, settings)),
      child_(started(program, directory_.write("model.json", model_.dump()),
                     directory_.path() + "/log.txt")) {
  version_ = answer().at("version");
}

nlohmann::json JoltProcess::answer() {
  for (const auto deadline = Clock::now() + kAnswer; Clock::now() < deadline;) {
    const auto lines = child_.lines();
    if (!lines.empty()) return nlohmann::json::parse(lines.front());
    if (child_.ended()) break;
    std::this_thread::sleep_for(kLook);
  }
  throw std::runtime_error("Jolt does not answer; its process ended or hangs");
}

std::vector<double> JoltProcess::run(const std::vector<double>& belt_speeds) {
  child_.write_line(nlohmann::json(belt_speeds).dump());
  const auto said = answer();
  contacts_ = said.at("contacts");
  deepest_m_ = said.at("deepest_m");
  return said.at("us");
}

std::vector<Pose> JoltProcess::poses() {
  child_.write_line("[]");
  const auto said = answer().at("poses");
  std::vector<Pose> out;
  std::size_t index = 0;
  for (const auto& body : model_.at("bodies")) {
    const auto& X = said.at(index++);
    if (body.at("motion") != "free") continue;
    const Eigen::Vector3d com(body.at("com").at(0), body.at("com").at(1), body.at("com").at(2));
    const Eigen::Quaterniond q(X.at(3), X.at(4), X.at(5), X.at(6));
    const Eigen::Vector3d at(X.at(0), X.at(1), X.at(2));
    out.push_back({at - q.normalized() * com, q.normalized()});
  }
  return out;
}

}  // namespace aprsim::bench
