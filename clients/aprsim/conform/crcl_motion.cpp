#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "clients/aprsim/conform/crcl_check_groups.hpp"
#include "clients/aprsim/conform/crcl_probe.hpp"
#include "crcl/command_codec.hpp"

namespace aprsim::client::conform::motion {
namespace {

using crcl::CommandState;

constexpr double kStep_mm = 5, kSpeed_mm_s = 10, kTurn_deg = 1, kTurnSpeed_deg_s = 2;
/// Tolerances of NIST's client at the end of a move.
constexpr double kNear_mm = 3, kNear_deg = 15;
constexpr Milliseconds kMove{20'000};

// Slow speeds, in millimetres and degrees.
CrclProbe ready(const Target& target) {
  CrclProbe probe(target);
  probe.init();
  probe.run(crcl::SetUnits{crcl::LengthUnit::kMillimeter});
  probe.run(crcl::SetUnits{crcl::AngleUnit::kDegree});
  probe.run(crcl::SetRate{crcl::RateKind::kTransSpeed, {false, kSpeed_mm_s}});
  return probe;
}

crcl::Pose pose_of(const SeenStatus& seen) {
  expect(seen.status.pose.has_value(), "no pose");
  return seen.status.pose->pose;
}

double distance(const crcl::Pose& a, const crcl::Pose& b) {
  return std::hypot(a.point.x - b.point.x, a.point.y - b.point.y, a.point.z - b.point.z);
}

crcl::Pose lifted(crcl::Pose pose, double by_mm) {
  pose.point.z += by_mm;
  return pose;
}

// Moves up and back.
std::string move(const Target& target, bool straight) {
  CrclProbe probe = ready(target);
  const crcl::Pose here = pose_of(probe.poll());
  double worst = 0;
  for (const crcl::Pose& goal : {lifted(here, kStep_mm), here}) {
    const std::int64_t id = probe.send(crcl::MoveTo{straight, {goal, std::nullopt}});
    const SeenStatus first = probe.poll();
    expect(first.status.command.command_id == id, in_words(first.status));
    const SeenStatus last = probe.wait_over(id, kMove);
    expect(last.status.command.state == CommandState::kDone, in_words(last.status));
    worst = std::max(worst, distance(pose_of(last), goal));
    expect(worst < kNear_mm, fmt::format("{:.3f} mm off", worst));
  }
  return fmt::format("CRCL_Done, {:.3f} mm off", worst);
}

std::string through(const Target& target) {
  CrclProbe probe = ready(target);
  const crcl::Pose here = pose_of(probe.poll());
  const SeenStatus seen = probe.run(
      crcl::MoveThroughTo{true, {{lifted(here, kStep_mm), std::nullopt}, {here, std::nullopt}}},
      kMove);
  const double off = distance(pose_of(seen), here);
  expect(off < kNear_mm, fmt::format("{:.3f} mm off", off));
  return fmt::format("CRCL_Done, {:.3f} mm off", off);
}

// Moves the last joint forth and back.
std::string joints(const Target& target) {
  CrclProbe probe = ready(target);
  const crcl::Status status = probe.poll().status;
  expect(!status.joints.empty() && status.joints.back().position, "no joints");
  const int joint = status.joints.back().joint;
  const double here = *status.joints.back().position;
  double worst = 0;
  for (const double goal : {here + kTurn_deg, here}) {
    const SeenStatus seen = probe.run(
        crcl::ActuateJoints{{{joint, goal, crcl::JointSpeedAccel{kTurnSpeed_deg_s, std::nullopt}}},
                            {}},
        kMove);
    worst = std::max(worst, std::abs(seen.status.joints.back().position.value_or(1e9) - goal));
    expect(worst < kNear_deg, fmt::format("{:.3f} degrees off", worst));
  }
  return fmt::format("CRCL_Done, {:.3f} degrees off", worst);
}

std::string stopped(const Target& target) {
  CrclProbe probe = ready(target);
  CrclProbe emergency(target);
  const crcl::Pose here = pose_of(probe.poll());
  crcl::CommandInstance instance;
  const std::int64_t move = instance.command.id = CrclProbe::next_id();
  instance.command.body = crcl::MoveTo{true, {lifted(here, 4 * kStep_mm), std::nullopt}};
  probe.send(crcl::encode_command(instance) + get_status_document());
  const SeenStatus moving = probe.read();
  expect(moving.status.command.state == CommandState::kWorking, in_words(moving.status));
  const auto until = std::chrono::steady_clock::now() + kMove;
  while (distance(pose_of(probe.poll()), here) < kStep_mm / 5) {
    expect(std::chrono::steady_clock::now() < until, "it does not move");
  }
  const std::int64_t id = emergency.send(crcl::StopMotion{crcl::StopCondition::kFast}, move - 1);
  const SeenStatus seen = probe.wait_over(id, kMove);
  expect(seen.status.command.state == CommandState::kDone, in_words(seen.status));
  const crcl::Pose rest = pose_of(seen);
  const double way = distance(rest, here);
  expect(way < 3.5 * kStep_mm, fmt::format("{:.1f} mm of {} gone", way, 4 * kStep_mm));
  const double creep = distance(pose_of(probe.poll()), rest);
  expect(creep < 0.5, fmt::format("it still moved {:.3f} mm", creep));
  probe.init();
  probe.run(crcl::MoveTo{true, {here, std::nullopt}}, kMove);
  return fmt::format("CRCL_Done after {:.1f} mm of {}", way, 4 * kStep_mm);
}

std::string out_of_reach(const Target& target) {
  CrclProbe probe = ready(target);
  const crcl::Pose here = pose_of(probe.poll());
  const std::int64_t id = probe.send(crcl::MoveTo{false, {lifted(here, 1e5), std::nullopt}});
  const SeenStatus seen = probe.wait_over(id, kMove);
  const std::string words = in_words(seen.status);
  probe.init();
  expect(seen.status.command.state == CommandState::kError, words);
  expect(distance(pose_of(seen), here) < kNear_mm, "it moved");
  return words;
}

std::string gripper(const Target& target) {
  CrclProbe probe = ready(target);
  const SeenStatus before = probe.poll();
  const double was = before.status.settings ? before.status.settings->end_effector.value_or(1) : 1;
  for (const double setting : {1.0, was}) {
    const SeenStatus seen = probe.run(crcl::SetEndEffector{setting}, kMove);
    expect(seen.status.settings && seen.status.settings->end_effector == setting,
           "another EndEffectorSetting");
  }
  return "CRCL_Done, reported as set";
}

}  // namespace

void add(std::vector<Check>& checks) {
  const auto rule = [&checks](const char* clause, const char* source, const char* text,
                              const char* expected, auto run) {
    checks.push_back({clause, source, text, expected, true, run});
  };
  constexpr const char* kClients = "NIST's Java clients";
  rule("M1", kClients, "MoveTo straight, 5 mm up and back", "CRCL_Done within 3 mm",
       [](const Target& t) { return move(t, true); });
  rule("M2", kClients, "MoveTo free, 5 mm up and back", "CRCL_Done within 3 mm",
       [](const Target& t) { return move(t, false); });
  rule("M3", kClients, "MoveThroughTo, 5 mm up and back", "CRCL_Done within 3 mm", through);
  rule("M4", kClients, "ActuateJoints, the last joint by a degree and back",
       "CRCL_Done within 15 degrees", joints);
  rule("M5", "CRCLCommands.xsd", "StopMotion on the way", "CRCL_Done, and the arm rests", stopped);
  rule("M6", "duty of a robot", "MoveTo 100 m up", "CRCL_Error, and nothing moves", out_of_reach);
  rule("M7", kClients, "SetEndEffector, open and back", "CRCL_Done, reported as set", gripper);
}

}  // namespace aprsim::client::conform::motion
