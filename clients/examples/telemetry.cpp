// Reads the cell by gRPC: what is in it, then five samples of the robots' tools.
//
//   aprsimd --any-port --ports-file ports.json &
//   APRSIM_PORTS_FILE=ports.json ./telemetry

#include <iostream>

#include "clients/wires/cell_connection.hpp"
#include "clients/wires/endpoints.hpp"

namespace client = aprsim::client;
namespace v1 = aprsim::v1;

namespace {

constexpr double kRate_hz = 20;  // samples a second of wall time
constexpr int kSamples = 5;

void show(const v1::Snapshot& snapshot) {
  const double time_s = static_cast<double>(snapshot.sim_time().seconds()) +
                        1e-9 * static_cast<double>(snapshot.sim_time().nanos());
  for (const auto& robot : snapshot.robots()) {
    // Positions are in metres, in the world frame.
    const auto& tool = robot.tool_in_world().position_m();
    std::cout << time_s << " s: " << robot.name() << " has its tool at (" << tool.x() << ", "
              << tool.y() << ", " << tool.z() << ") m\n";
  }
}

client::Outcome<void> run() {
  const auto endpoints = client::find_endpoints({});
  if (!endpoints) return tl::unexpected(endpoints.error());
  client::CellConnection cell(*endpoints);

  // The description holds what does not change, the snapshots what does.
  const auto description = cell.cell();
  if (!description) return tl::unexpected(description.error());
  std::cout << description->scene() << ": " << description->robots_size() << " robots, "
            << description->bodies_size() << " bodies\n";

  int samples = 0;
  return cell.stream(kRate_hz, [&](const v1::StreamSnapshotsResponse& sample) {
    show(sample.snapshot());
    return ++samples < kSamples;
  });
}

}  // namespace

int main() {
  const auto done = run();
  if (!done) std::cerr << "telemetry: " << done.error().message << '\n';
  return done ? 0 : 1;
}
