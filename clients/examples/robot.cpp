// Moves a robot by CRCL, the wire of its controller: lowers the tool by 50 mm, closes and opens the
// gripper, and raises the tool again.
//
//   aprsimd --any-port --ports-file ports.json &
//   APRSIM_PORTS_FILE=ports.json ./robot [NAME]

#include <chrono>
#include <iostream>
#include <string>

#include "clients/wires/crcl_session.hpp"
#include "clients/wires/endpoints.hpp"

namespace client = aprsim::client;
namespace crcl = aprsim::crcl;
using namespace std::chrono_literals;

namespace {

/// Moves the tool straight along the vertical axis of the robot's frame.
client::Outcome<crcl::Status> lift(client::CrclSession& robot, double by_mm) {
  const auto now = robot.status();
  if (!now) return now;
  if (!now->pose) return client::failed(client::FailureKind::kCheck, "the robot reports no pose");
  crcl::MoveTo move;
  move.straight = true;
  move.end.pose = now->pose->pose;
  move.end.pose.point.z += by_mm;
  return robot.run(move, 60s);
}

client::Outcome<void> run(const std::string& name) {
  // The ports file that APRSIM_PORTS_FILE names, or else the default ports.
  const auto endpoints = client::find_endpoints({});
  if (!endpoints) return tl::unexpected(endpoints.error());
  auto robot = client::CrclSession::connect(*endpoints, name);
  if (!robot) return tl::unexpected(robot.error());

  // A session of CRCL begins with InitCanon. Each command returns when the robot reports it as
  // done.
  const crcl::CommandBody begin[] = {crcl::InitCanon{},
                                     crcl::SetUnits{crcl::LengthUnit::kMillimeter}};
  for (const auto& command : begin) {
    if (const auto done = robot->run(command, 30s); !done) return tl::unexpected(done.error());
  }
  const auto lowered = lift(*robot, -50);
  if (!lowered) return tl::unexpected(lowered.error());
  std::cout << name << ": the tool is at z = " << lowered->pose->pose.point.z << " mm\n";

  for (const double opening : {0.0, 1.0}) {
    const auto set = robot->run(crcl::SetEndEffector{opening}, 30s);
    if (!set) return tl::unexpected(set.error());
  }
  const auto raised = lift(*robot, 50);
  if (!raised) return tl::unexpected(raised.error());
  std::cout << name << ": raised by " << raised->pose->pose.point.z - lowered->pose->pose.point.z
            << " mm\n";
  const auto ended = robot->run(crcl::EndCanon{}, 30s);
  if (!ended) return tl::unexpected(ended.error());
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  const auto done = run(argc > 1 ? argv[1] : "fanuc");
  if (!done) std::cerr << "robot: " << done.error().message << '\n';
  return done ? 0 : 1;
}
