#include "world/faults/fault_check.hpp"

#include <limits>
#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "tests/support/cell_script.hpp"
#include "world/cell/commands/command_check.hpp"
#include "world/cell/describe_cell.hpp"

namespace aprsim::world {
namespace {

const CellNames& default_names() {
  static const World world(test::load_scene("aprs"), 1);
  return world.description();
}
const api::CellDescription& default_cell() { return *default_names(); }

api::InjectFault request(const std::string& kind, const std::string& target = "") {
  return {.kind = kind, .target = target, .parameters = {}, .trigger = {}, .duration = {}};
}

/// Field and message of the refusal.
std::string why_refused(const api::InjectFault& fault,
                        const api::CellDescription& cell = default_cell()) {
  const auto spec = resolve(fault, cell);
  return spec ? "taken" : spec.error().field + ": " + spec.error().message;
}

TEST(FaultCheck, ResolvesTargetsParametersAndTriggers) {
  auto fault = request("joint-weak", "motoman:7");
  fault.parameters["share"] = 0.5;
  fault.trigger = api::WhenGrasped{"fanuc", 3};
  fault.duration = std::chrono::seconds(2);
  const auto spec = resolve(fault, default_cell());
  ASSERT_TRUE(spec) << spec.error().message;
  EXPECT_EQ(spec->robot, 1);
  EXPECT_EQ(spec->joint, 6);
  EXPECT_EQ(spec->value("share"), 0.5);
  EXPECT_EQ(spec->trigger_robot, 0);
  EXPECT_EQ(describe(spec->trigger), "at grasp 3 of fanuc");
  const auto plain = resolve(request("camera-scale", "fanuc"), default_cell());
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->value("factor"), 1.02) << "the kind's own";
  for (const auto& kind : faults::all_kinds()) {
    const std::string target =
        kind.target == faults::Target::kCell       ? ""
        : kind.target == faults::Target::kRobot    ? "fanuc"
        : kind.target == faults::Target::kJoint    ? "fanuc:1"
        : kind.target == faults::Target::kGear     ? "part_large_gear_1"
        : kind.target == faults::Target::kTray     ? "kit_s2l2_vessel_1"
        : kind.target == faults::Target::kPair     ? "part_large_gear_1:part_medium_gear_1"
        : kind.target == faults::Target::kSighting ? "fanuc:part_large_gear_1"
        : kind.target == faults::Target::kCamera   ? "fanuc_table"
                                                   : "upstream";
    EXPECT_EQ(why_refused(request(std::string(kind.name), target)), "taken") << kind.name;
  }
}

TEST(FaultCheck, RefusalsNameFieldValueAndLimit) {
  EXPECT_NE(why_refused(request("gremlins")).find("kind: 'gremlins' is no kind"),
            std::string::npos);
  EXPECT_NE(why_refused(request("robot-slow")).find("target: robot-slow needs a target, ROBOT"),
            std::string::npos);
  EXPECT_NE(why_refused(request("robot-slow", "r2d2")).find("'r2d2' is no robot"),
            std::string::npos);
  EXPECT_NE(why_refused(request("robot-slow", "r2d2")).find("fanuc, motoman"), std::string::npos);
  EXPECT_NE(why_refused(request("picture-dirt", "fanuc"))
                .find("'fanuc' is no camera of the cell; there are: fanuc_table, motoman_belt"),
            std::string::npos);
  auto spots = request("picture-dirt", "fanuc_table");
  spots.parameters["spots"] = 2.5;
  EXPECT_NE(why_refused(spots).find("spots is 2.5, must be a whole number"), std::string::npos);
  EXPECT_NE(why_refused(request("belt-jam", "fanuc")).find("has no target"), std::string::npos);
  for (const char* joint : {"fanuc:0", "fanuc:7", "fanuc:one", "fanuc:1.5", "fanuc:-1"}) {
    EXPECT_NE(why_refused(request("joint-weak", joint)).find("has joints 1 to 6"),
              std::string::npos)
        << joint;
  }
  for (const char* target : {"fanuc", "fanuc:", ":1", ""}) {
    EXPECT_NE(why_refused(request("joint-weak", target)).find("ROBOT:NUMBER"), std::string::npos);
  }
  EXPECT_NE(why_refused(request("part-missing", "kit_s2l2_vessel_1")).find("is no gear"),
            std::string::npos);
  EXPECT_NE(why_refused(request("tray-shifted", "part_large_gear_1")).find("is no tray"),
            std::string::npos);
  EXPECT_NE(
      why_refused(request("part-swapped", "part_large_gear_1:part_large_gear_1")).find("twice"),
      std::string::npos);
  EXPECT_NE(why_refused(request("photo-eye-stuck-on", "cyclops")).find("upstream, downstream"),
            std::string::npos);
  EXPECT_NE(why_refused(request("belt-jam", std::string(200, 'x'))).find("200 bytes"),
            std::string::npos);

  auto fault = request("robot-slow", "fanuc");
  for (const double share : {-0.1, 1.5, std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()}) {
    fault.parameters = {{"share", share}};
    EXPECT_NE(why_refused(fault).find("must be within 0 to 1"), std::string::npos) << share;
  }
  fault.parameters = {{"pace", 0.5}};
  EXPECT_NE(why_refused(fault).find("no parameter 'pace'; it has: share"), std::string::npos);
  auto code = request("modbus-exceptions");
  code.parameters = {{"code", 2.5}};
  EXPECT_NE(why_refused(code).find("code is 2.5, must be a whole number"), std::string::npos);
}

TEST(FaultCheck, TimesAreNotNegativeAndMomentaryKindsHaveNone) {
  auto fault = request("belt-jam");
  fault.trigger = api::AtTime{std::chrono::milliseconds(-1)};
  EXPECT_NE(why_refused(fault).find("at: at is -0.001 s, must be within 0"), std::string::npos);
  fault.trigger = {};
  for (const auto duration : {SimTime(0), SimTime(std::chrono::seconds(-3))}) {
    fault.duration = duration;
    EXPECT_NE(why_refused(fault).find("must be above 0"), std::string::npos);
  }
  auto stop = request("protective-stop", "fanuc");
  stop.duration = std::chrono::seconds(3);
  EXPECT_NE(why_refused(stop).find("is momentary, but a duration of 3 s"), std::string::npos);
}

TEST(FaultCheck, ATriggerNeedsItsObject) {
  auto fault = request("belt-jam");
  const auto with = [&](api::FaultTrigger trigger) {
    fault.trigger = std::move(trigger);
    return why_refused(fault);
  };
  EXPECT_NE(with(api::WhenPlaced{}).find("no type of gear is named"), std::string::npos);
  EXPECT_NE(with(api::WhenPlaced{"cog", ""}).find("'cog' is no type"), std::string::npos);
  EXPECT_NE(with(api::WhenPlaced{"sku_part_large_gear", "r2d2"}).find("'r2d2' is no robot"),
            std::string::npos);
  EXPECT_EQ(with(api::WhenPlaced{"sku_part_large_gear", ""}), "taken");
  EXPECT_NE(with(api::WhenGrasped{}).find("no robot is named"), std::string::npos);
  EXPECT_NE(with(api::WhenGrasped{"fanuc", 0}).find("count is 0, must be 1"), std::string::npos);
  EXPECT_NE(with(api::WhenBeamBroken{}).find("no photo-eye is named"), std::string::npos);
  EXPECT_NE(with(api::WhenReported{}).find("a name of 0 bytes"), std::string::npos);
  using faults::Quantity;
  EXPECT_NE(with(api::WhenCrossing{Quantity::kToolForce, "", 1, true, 5}).find("needs a robot"),
            std::string::npos);
  EXPECT_NE(with(api::WhenCrossing{Quantity::kBeltSpeed, "fanuc", 1, true, 5}).find("no robot's"),
            std::string::npos);
  EXPECT_NE(
      with(api::WhenCrossing{Quantity::kJointPosition, "fanuc", 9, true, 5}).find("joints 1 to 6"),
      std::string::npos);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(with(api::WhenCrossing{Quantity::kBeltSpeed, "", 1, true, nan}).find("not a finite"),
            std::string::npos);
}

TEST(FaultCheck, ACellWithoutBeltOrCurtainHasNoneOfTheirFaults) {
  const World world(test::load_scene("fanuc_only"), 1);
  const api::CellDescription& cell = *world.description();
  ASSERT_FALSE(cell.has_conveyor);
  EXPECT_NE(why_refused(request("belt-jam"), cell).find("has no conveyor"), std::string::npos);
  EXPECT_EQ(why_refused(request("modbus-silent"), cell), "taken")
      << "the PLC answers without a belt";
  if (!cell.light_curtain) {
    EXPECT_NE(why_refused(request("curtain-broken"), cell).find("no light curtain"),
              std::string::npos);
  }
}

TEST(FaultCheck, CommandsAreCheckedWhenTheyAreSubmitted) {
  const auto error = [](api::FaultCommand body) {
    api::Command command{.body = std::move(body)};
    const auto ok = check(command, default_names());
    return ok ? std::string() : ok.error().field;
  };
  EXPECT_EQ(error(request("gremlins")), "kind");
  EXPECT_EQ(error(request("belt-jam")), "");
  EXPECT_EQ(error(api::ReportEvent{""}), "event");
  EXPECT_EQ(error(api::ReportEvent{std::string(1000, 'x')}), "event");
  EXPECT_EQ(error(api::EndFault{4711}), "") << "known when it is carried out";
}

/// The default cell with another name for its first robot: other names, other indices.
CellNames renamed_cell() {
  auto cell = std::make_shared<api::CellDescription>(default_cell());
  std::swap(cell->robots[0].name, cell->robots[1].name);
  return cell;
}

TEST(FaultCheck, ACheckedFaultKeepsItsIndicesWhileTheDescriptionIsTheSame) {
  api::Command command{.body = api::FaultCommand(request("robot-slow", "fanuc"))};
  ASSERT_TRUE(check(command, default_names()));
  auto& fault = std::get<api::InjectFault>(std::get<api::FaultCommand>(command.body));
  ASSERT_TRUE(fault.resolved);
  fault.target = "nobody";  // resolving again would fail
  const auto kept = spec_of(fault, default_names());
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->robot, 0);
  EXPECT_FALSE(spec_of(fault, renamed_cell())) << "resolved anew";
  fault.target = "fanuc";
  EXPECT_EQ(spec_of(fault, renamed_cell())->robot, 1);
  fault.resolved.reset();
  EXPECT_EQ(spec_of(fault, default_names())->robot, 0) << "never checked";
}

TEST(FaultCheck, ACheckedCrossingKeepsItsRobotWhileTheDescriptionIsTheSame) {
  const api::WhenCrossing crossing{faults::Quantity::kToolHeight, "motoman", 1, true, 1};
  api::Command command{.body = api::SimulationCommand(api::RunUntil{crossing})};
  ASSERT_TRUE(check(command, default_names()));
  const auto& run = std::get<api::RunUntil>(std::get<api::SimulationCommand>(command.body));
  ASSERT_TRUE(run.resolved);
  api::WhenCrossing unknown = crossing;
  unknown.robot = "nobody";
  EXPECT_EQ(robot_of(unknown, run.resolved, default_names()), 1);
  EXPECT_FALSE(robot_of(unknown, run.resolved, renamed_cell())) << "resolved anew";
  EXPECT_EQ(robot_of(crossing, run.resolved, renamed_cell()), 0);
  EXPECT_EQ(robot_of(crossing, nullptr, default_names()), 1) << "never checked";
}

}  // namespace
}  // namespace aprsim::world
