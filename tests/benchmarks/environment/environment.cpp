// Steps of the Python package's environment `pick` a second, beside a program in C++ that drives
// the same episodes: what Python has sent over CRCL and gRPC, in the same order, from the same
// states, to the same daemon, with every answer read. Both must end in the same state, bit for bit;
// so must the same episodes in a cell of Python's own process, whose time is compared with the
// daemon's.

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tests/benchmarks/support/experiment.hpp"
#include "tests/benchmarks/support/table.hpp"
#include "tests/support/cell_client.hpp"
#include "tests/support/daemon_process.hpp"
#include "tests/support/tcp_socket.hpp"
#include "tests/support/temporary_directory.hpp"

namespace aprsim::bench {
namespace {

using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr auto kAnswer = std::chrono::seconds(60);

std::string from_base64(const std::string& text) {
  constexpr std::string_view kSigns =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char sign : text) {
    const auto value = kSigns.find(sign);
    if (value == std::string_view::npos) break;
    bits = bits << 6U | static_cast<std::uint32_t>(value);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> static_cast<unsigned>(count) & 0xFFU);
  }
  return bytes;
}

/// Sends again what the environment has sent.
class Driver {
 public:
  Driver(const test::DaemonProcess& daemon, const std::vector<std::string>& opening)
      : cell_(daemon.port("grpc")), robot_(daemon.port("crcl.fanuc")) {
    for (const std::string& document : opening) say(document);
  }

  void load(const std::string& state) {
    v1::LoadStateRequest request;
    request.set_name(state);
    (void)call<v1::LoadStateResponse>(&v1::ControlService::Stub::LoadState, *cell_.control,
                                      request);
  }

  void send(const std::string& kind, const std::string& text) {
    if (kind == "crcl") {
      say(text);
    } else if (kind == "Step") {
      v1::StepRequest request;
      request.ParseFromString(from_base64(text));
      (void)call<v1::StepResponse>(&v1::ControlService::Stub::Step, *cell_.control, request);
    } else if (kind == "GetSnapshot") {
      v1::GetSnapshotRequest request;
      request.ParseFromString(from_base64(text));
      (void)call<v1::GetSnapshotResponse>(&v1::TelemetryService::Stub::GetSnapshot,
                                          *cell_.telemetry, request);
    } else {
      throw std::runtime_error("an episode calls " + kind);
    }
  }

  [[nodiscard]] std::uint64_t state_hash() { return cell_.snapshot().state_hash(); }

 private:
  template <typename Response, typename Stub, typename Method, typename Request>
  Response call(Method method, Stub& stub, const Request& request) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + kAnswer);
    Response response;
    test::CellClient::require((stub.*method)(&context, request, &response));
    return response;
  }

  /// A document; the caller waits for the status.
  void say(const std::string& document) {
    if (!robot_.send(document)) throw std::runtime_error("the robot takes no document");
    if (document.find("GetStatusType") == std::string::npos) return;
    constexpr std::string_view kEnd = "</CRCLStatus>";
    std::size_t end = std::string::npos;
    while ((end = input_.find(kEnd)) == std::string::npos) {
      input_ += robot_.receive(Clock::now() + kAnswer);
    }
    input_.erase(0, end + kEnd.size());
  }

  test::CellClient cell_;
  test::TcpSocket robot_;
  std::string input_;
};

/// Actions and results of the Python environment.
Json play_in_python(const test::DaemonProcess& daemon, int episodes) {
  const test::TemporaryDirectory directory;
  const std::string file = directory.path() + "/episodes.json";
  ::setenv("PYTHONPATH", APRSIM_SOURCE_DIR "/clients/python", 1);
  const auto done = test::run_process(
      {"/usr/bin/python3", APRSIM_SOURCE_DIR "/tests/benchmarks/environment/episodes.py",
       daemon.ports_file(), std::to_string(episodes), file},
      std::chrono::seconds(600));
  if (done.exit_code != 0) throw std::runtime_error("episodes.py: " + done.err);
  std::ifstream in(file);
  return Json::parse(in);
}

int run(int argc, char** argv) {
  Experiment experiment("environment", argc, argv);
  const test::DaemonProcess daemon({"--speed", "stepped"});
  const Json python = play_in_python(daemon, experiment.quick() ? 2 : 20);
  Driver driver(daemon, python["opening"].get<std::vector<std::string>>());
  Table table({"episode", "environment steps", "cell steps", "Python [steps/s]", "C++ [steps/s]"});
  double python_s = 0, driver_s = 0, steps = 0, cell_steps = 0;
  int solved = 0, same = 0, number = 0;
  for (const Json& episode : python["episodes"]) {
    driver.load(episode["state"]);
    const auto began = Clock::now();
    for (const Json& message : episode["sent"]) driver.send(message[0], message[1]);
    const double took_s = std::chrono::duration<double>(Clock::now() - began).count();
    const double taken = episode["steps"], python_took_s = episode["taken_s"];
    same += std::to_string(driver.state_hash()) == episode["state_hash"] ? 1 : 0;
    solved += episode["success"] ? 1 : 0;
    table.row({static_cast<double>(++number), taken, episode["cell_steps"].get<double>(),
               taken / python_took_s, taken / took_s});
    steps += taken;
    cell_steps += episode["cell_steps"].get<double>();
    python_s += python_took_s;
    driver_s += took_s;
  }
  double here_s = 0;
  int same_here = 0;
  for (std::size_t i = 0; i < python["here"].size(); ++i) {
    const Json& episode = python["here"][i];
    here_s += episode["taken_s"].get<double>();
    same_here += episode["state_hash"] == python["episodes"][i]["state_hash"] ? 1 : 0;
  }
  const double by_here = steps / here_s;
  const double by_python = steps / python_s, by_driver = steps / driver_s;
  experiment.record(
      {"environment.pick_steps_per_s", by_python, "1/s", "the same in C++", by_python / by_driver});
  experiment.record("environment.pick_steps_per_s.cpp", by_driver, "1/s");
  experiment.record("environment.pick_simulated_over_wall", cell_steps / 1e3 / python_s, "x");
  experiment.record("environment.pick_solved", static_cast<double>(solved) / number, "");
  experiment.record("environment.pick_same_bits", static_cast<double>(same) / number, "");
  experiment.record(
      {"environment.world.pick_steps_per_s", by_here, "1/s", "in a daemon", by_here / by_python});
  experiment.record("environment.world.pick_simulated_over_wall", cell_steps / 1e3 / here_s, "x");
  experiment.record("environment.world.pick_same_bits", static_cast<double>(same_here) / number,
                    "");
  const double alone_s = python["here_s"], together_s = python["threads_s"];
  const double threads = python["threads"];
  experiment.record({"environment.world.threads_speed_up", number * threads / together_s, "1/s",
                     "one thread", threads * alone_s / together_s});
  experiment.record("environment.world.rest_simulated_over_wall", python["rest_over_wall"], "x");
  experiment.note(
      fmt::format("{} episodes of `PickEnv` by its scripted policy, {} steps of the environment, "
                  "{} of the cell.",
                  number, steps, cell_steps));
  experiment.table("episodes", "Episodes", table);
  return experiment.finish();
}

}  // namespace
}  // namespace aprsim::bench

int main(int argc, char** argv) { return aprsim::bench::run(argc, argv); }
