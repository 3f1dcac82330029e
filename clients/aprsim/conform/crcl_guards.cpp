#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "clients/aprsim/conform/crcl_check_groups.hpp"
#include "clients/aprsim/conform/crcl_probe.hpp"
#include "crcl/command_codec.hpp"
#include "crcl/schema.hpp"

namespace aprsim::client::conform::guards {
namespace {

using crcl::CommandState;
using crcl::GuardLimit;
using std::chrono::duration;
using std::chrono::steady_clock;

/// Far beyond any force, in any unit.
constexpr double kBeyond = 1e9;
constexpr double kShort_s = 0.4, kLong_s = 20;
constexpr Milliseconds kSoon{3000}, kMove{20'000};

/// Names of force sensors: NIST's controllers' and this project's.
constexpr std::array kSensors{"force_torque", "MotoFit", "RemoteCrclSensor", "ATINetFT"};

bool reports(const crcl::Status& status, const std::string& sensor) {
  return status.sensors &&
         std::ranges::any_of(status.sensors->force_torque,
                             [&](const auto& force) { return force.reading.sensor_id == sensor; });
}

/// The sensor for guards: the chosen one, or the first known name that the server accepts. The
/// probe has a session without an error afterwards.
std::string sensor_of(CrclProbe& probe, const Target& target) {
  probe.init();
  if (!target.sensor.empty()) return target.sensor;
  probe.run(crcl::ConfigureStatusReport{true, true, true, true, true, true});
  for (const char* sensor : kSensors) {
    const std::int64_t id = probe.send(crcl::EnableSensor{sensor, {}});
    const SeenStatus seen = probe.wait_over(id, CrclProbe::kAnswer);
    if (seen.status.command.state == CommandState::kDone && reports(seen.status, sensor)) {
      return sensor;
    }
    probe.init();
  }
  throw NotApplicable{"no sensor of forces by a known name; --sensor names one"};
}

crcl::Guard guard(const std::string& sensor, GuardLimit limit, double value) {
  crcl::Guard guard;
  guard.name = "conform";
  guard.sensor_id = sensor;
  guard.sub_field = "Fz";
  guard.limit = limit;
  guard.limit_value = value;
  return guard;
}
/// A guard that holds from the start, at any force.
crcl::Guard met(const std::string& sensor) { return guard(sensor, GuardLimit::kOverMax, -kBeyond); }
/// A guard that never holds.
crcl::Guard unmet(const std::string& sensor) {
  return guard(sensor, GuardLimit::kOverMax, kBeyond);
}

/// Sends a command with that guard and returns its id.
std::int64_t send(CrclProbe& probe, const crcl::CommandBody& body, const crcl::Guard& guard) {
  crcl::CommandInstance instance;
  instance.command.id = CrclProbe::next_id();
  instance.command.body = body;
  instance.command.guards = {guard};
  probe.send(crcl::encode_command(instance));
  return instance.command.id;
}

/// End and duration of a dwell with that guard.
struct Ended {
  SeenStatus seen;
  double after_s = 0;
};
Ended dwell(CrclProbe& probe, double time_s, const crcl::Guard& guard) {
  const auto began = steady_clock::now();
  const std::int64_t id = send(probe, crcl::Dwell{time_s}, guard);
  SeenStatus seen = probe.wait_over(id, kSoon);
  return {std::move(seen), duration<double>(steady_clock::now() - began).count()};
}

// A dwell under a guard with an invalid text.
auto refuses(std::string guard) {
  return [guard = std::move(guard)](const Target& target) {
    CrclProbe probe(target);
    const std::string sensor = sensor_of(probe, target);
    const std::int64_t id = CrclProbe::next_id();
    return refused(target,
                   command_document("DwellType", id,
                                    fmt::format("<Guard><SensorID>{}</SensorID><SubField>Fz"
                                                "</SubField>{}</Guard><DwellTime>0</DwellTime>",
                                                sensor, guard)),
                   id);
  };
}

std::string unknown_sensor(const Target& target) {
  const std::int64_t id = CrclProbe::next_id();
  return refused(target,
                 command_document("DwellType", id,
                                  "<Guard><SensorID>no such sensor</SensorID><SubField>Fz"
                                  "</SubField><LimitType>OVER_MAX</LimitType><LimitValue>1"
                                  "</LimitValue></Guard><DwellTime>0</DwellTime>"),
                 id);
}

std::string ends(const Target& target, GuardLimit limit, double value) {
  CrclProbe probe(target);
  const std::string sensor = sensor_of(probe, target);
  const Ended ended = dwell(probe, kLong_s, guard(sensor, limit, value));
  expect_state(ended.seen, CommandState::kDone);
  return fmt::format("CRCL_Done after {:.2f} s", ended.after_s);
}

std::string error(const Target& target) {
  CrclProbe probe(target);
  crcl::Guard guard = met(sensor_of(probe, target));
  guard.error_on_trigger = true;
  const Ended ended = dwell(probe, kLong_s, guard);
  const std::string words = in_words(ended.seen.status);
  probe.init();
  expect(ended.seen.status.command.state == CommandState::kError, words);
  expect(!ended.seen.status.command.description.value_or("").empty(),
         "an error without a description");
  return words;
}

/// The command just sent runs to its own end.
void expect_whole(CrclProbe& probe, std::int64_t id) {
  const SeenStatus first = probe.poll();
  expect(first.status.command.command_id == id, in_words(first.status));
  expect_state(first, CommandState::kWorking);
  expect_state(probe.wait_over(id, kSoon), CommandState::kDone);
}

std::string leaves_alone(const Target& target) {
  CrclProbe probe(target);
  const std::string sensor = sensor_of(probe, target);
  for (const crcl::Guard& guard : {unmet(sensor), guard(sensor, GuardLimit::kUnderMin, -kBeyond),
                                   guard(sensor, GuardLimit::kIncreaseOverLimit, kBeyond),
                                   guard(sensor, GuardLimit::kDecreaseBeyondLimit, kBeyond)}) {
    expect_whole(probe, send(probe, crcl::Dwell{kShort_s}, guard));
  }
  return "4 times CRCL_Working, then CRCL_Done";
}

std::string required(const Target& target) {
  CrclProbe probe(target);
  crcl::Guard guard = unmet(sensor_of(probe, target));
  guard.require_trigger = true;
  const Ended ended = dwell(probe, kShort_s, guard);
  const std::string words = in_words(ended.seen.status);
  probe.init();
  expect(ended.seen.status.command.state == CommandState::kError, words);
  return words;
}

std::string of_one_command(const Target& target) {
  CrclProbe probe(target);
  const std::string sensor = sensor_of(probe, target);
  expect_state(dwell(probe, kLong_s, met(sensor)).seen, CommandState::kDone);
  expect_whole(probe, probe.send(crcl::Dwell{kShort_s}));
  return "CRCL_Working, then CRCL_Done";
}

std::string reported(const Target& target) {
  CrclProbe probe(target);
  const std::string sensor = sensor_of(probe, target);
  const crcl::Status before =
      probe.run(crcl::ConfigureStatusReport{true, true, true, true, true, true}).status;
  const SeenStatus seen = dwell(probe, kLong_s, met(sensor)).seen;
  expect_state(seen, CommandState::kDone);
  expect(seen.status.guards.has_value(), "no GuardsStatuses");
  const crcl::GuardsStatuses& guards = *seen.status.guards;
  expect(guards.guards.size() == 1 && guards.guards.front().sensor_id == sensor,
         fmt::format("{} guards", guards.guards.size()));
  const int triggers = guards.trigger_count - (before.guards ? before.guards->trigger_count : 0);
  expect(triggers == 1, fmt::format("TriggerCount {} more", triggers));
  if (const auto fault = crcl::schema_fault(seen.document)) throw NotKept{fault->message()};
  return "the guard, TriggerCount 1 more";
}

// Moves up by 40 mm; the guard ends the motion at once.
std::string stops(const Target& target) {
  constexpr double kUp_mm = 40, kSpeed_mm_s = 10, kNear_mm = 5;
  CrclProbe probe(target);
  const std::string sensor = sensor_of(probe, target);
  probe.run(crcl::SetUnits{crcl::LengthUnit::kMillimeter});
  probe.run(crcl::SetRate{crcl::RateKind::kTransSpeed, {false, kSpeed_mm_s}});
  const auto here = probe.poll().status.pose;
  expect(here.has_value(), "no pose");
  crcl::Pose goal = here->pose;
  goal.point.z += kUp_mm;
  const std::int64_t id = send(probe, crcl::MoveTo{true, {goal, std::nullopt}}, met(sensor));
  const SeenStatus seen = probe.wait_over(id, kMove);
  expect_state(seen, CommandState::kDone);
  expect(seen.status.pose.has_value(), "no pose");
  const double way_mm = std::abs(seen.status.pose->pose.point.z - here->pose.point.z);
  probe.run(crcl::MoveTo{true, {here->pose, std::nullopt}}, kMove);
  expect(way_mm < kNear_mm, fmt::format("{:.1f} mm of {} gone", way_mm, kUp_mm));
  return fmt::format("CRCL_Done after {:.1f} mm of {}", way_mm, kUp_mm);
}

}  // namespace

void add(std::vector<Check>& checks) {
  const auto rule = [&checks](const char* clause, const char* text, const char* expected, auto run,
                              bool moves = false) {
    checks.push_back({clause, "DataPrimitives.xsd, GuardType", text, expected, moves, run});
  };
  constexpr const char* kRefused = "CRCL_Error with a description, under its id or closed";
  rule("G1", "a guard of a sensor that is not there", kRefused, unknown_sensor);
  rule("G2", "a guard with a limit of no known type", kRefused,
       refuses("<LimitType>SIDEWAYS</LimitType><LimitValue>1</LimitValue>"));
  rule("G3", "a guard without a limit's value", kRefused,
       refuses("<LimitType>OVER_MAX</LimitType>"));
  rule("G4", "a dwell of 20 s under OVER_MAX, met", "CRCL_Done within 3 s",
       [](const Target& t) { return ends(t, GuardLimit::kOverMax, -kBeyond); });
  rule("G5", "a dwell of 20 s under UNDER_MIN, met", "CRCL_Done within 3 s",
       [](const Target& t) { return ends(t, GuardLimit::kUnderMin, kBeyond); });
  rule("G6", "ErrorOnTrigger", "CRCL_Error with a description", error);
  rule("G7", "guards of each type that are not met", "CRCL_Done at the command's own end",
       leaves_alone);
  rule("G8", "RequireTrigger of a guard that is not met", "CRCL_Error", required);
  rule("G9", "a guard ends its own command only", "CRCL_Done of the next one at its own end",
       of_one_command);
  rule("G10", "ReportGuardsStatus", "the guard, TriggerCount 1 more", reported);
  rule("G11", "MoveTo under a guard that is met", "CRCL_Done before 5 mm", stops, true);
}

}  // namespace aprsim::client::conform::guards
