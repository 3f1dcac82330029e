#include <algorithm>
#include <ostream>

#include "tests/unit/world/scene/scene_fixture.hpp"

namespace aprsim::scene {
namespace {

/// One thing wrong in the small scene: `from` becomes `to`. A '@' marks the place that the error
/// must name, and is taken out; `mark` names text to put it before when that is elsewhere.
struct Case {
  const char* name;
  const char* from;
  const char* to;
  const char* key;
  const char* message;  ///< after "FILE:LINE:COLUMN: KEY: "
  const char* mark = nullptr;
};

std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }

class SceneErrors : public SceneFiles, public testing::WithParamInterface<Case> {};

TEST_P(SceneErrors, NamesFilePlaceKeyAndWhatWasExpected) {
  const Case& c = GetParam();
  std::string text = replaced(small_scene(), c.from, c.to);
  if (c.mark) text = replaced(text, c.mark, std::string("@") + c.mark);
  const std::size_t at = text.find('@');
  ASSERT_NE(at, std::string::npos);
  text.erase(at, 1);
  const auto before = text.begin() + static_cast<std::ptrdiff_t>(at);
  const auto line = 1 + std::count(text.begin(), before, '\n');
  const std::size_t line_start = at == 0 ? 0 : text.rfind('\n', at - 1) + 1;
  const std::size_t column = at - line_start + 1;
  write("arm.urdf", "<robot/>");
  const std::string file = write("scene.yaml", text);

  const auto scene = load(file);

  ASSERT_FALSE(scene.has_value());
  EXPECT_EQ(scene.error().field, c.key);
  const std::string key = *c.key ? std::string(c.key) + ": " : "";
  EXPECT_EQ(scene.error().message, file + ':' + std::to_string(line) + ':' +
                                       std::to_string(column) + ": " + key + c.message);
}

INSTANTIATE_TEST_SUITE_P(
    Yaml, SceneErrors,
    testing::Values(Case{"duplicate_key", "seed: 7\n", "seed: 7\n@seed: 8\n", "seed",
                         "found a second time, expected once (first at line 1)"},
                    Case{"alias", "seed: 7", "seed: @*x", "",
                         "found text that is not YAML: the referenced "
                         "anchor is not defined"},
                    Case{"anchor", "seed: 7", "seed: @&x 7", "",
                         "found an anchor (&name), expected a plain value"},
                    Case{"tag", "seed: 7", "seed: @!!int 7", "",
                         "found the tag tag:yaml.org,2002:int, expected a plain value"},
                    Case{"second_document", "gears:\n  - {name: wheel_2",
                         "---\n@gears:\n  - {name: wheel_2", "",
                         "found a second document, expected one in the file"},
                    Case{"key_not_a_word", "seed: 7", "@[a]: 7", "",
                         "found a key that is not a word, expected a name"}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Keys, SceneErrors,
    testing::Values(
        Case{"unknown_with_suggestion", "  max_speed_m_s: 0.3", "  @max_sped_m_s: 0.3",
             "conveyor.max_sped_m_s",
             "found an unknown key, expected one of xyz_m, rpy_deg, length_m, width_m, "
             "max_speed_m_s, max_accel_m_s2, max_decel_m_s2, emergency_decel_m_s2, photo_eyes (did "
             "you mean max_speed_m_s?)"},
        Case{"unknown_at_top", "seed: 7", "@colour: 7", "colour",
             "found an unknown key, expected one of base, seed, types, physics, pockets, "
             "gear_types, "
             "tray_types, part_types, robot_types, tools, robots, cameras, conveyor, "
             "light_curtain, fixed, fixtures, holders, floor, trays, gears, parts, devices, "
             "modbus_servers"},
        Case{"extension_with_a_path", "seed: 7", "devices: [{name: a, extension: @../b}]",
             "devices[0].extension",
             "found \"../b\", expected the name of an extension: up to 64 letters, digits, '_' and "
             "'-'"},
        Case{"two_devices_of_a_name", "seed: 7",
             "devices: [{name: a, extension: b}, {name: @a, extension: c}]", "devices[1].name",
             "found \"a\", expected a name that no other device has"},
        Case{"map_as_a_parameter", "seed: 7",
             "devices: [{name: a, extension: b, parameters: {c: @{d: 1}}}]",
             "devices[0].parameters.c", "found a map, expected text"},
        Case{"unknown_in_list", "yaw_deg: 90\n", "@yaw_degg: 90\n", "trays[0].yaw_degg",
             "found an unknown key, expected one of name, type, on, xy_m, yaw_deg, xyz_m, "
             "rpy_deg, gears, reachable_by (did you mean yaw_deg?)"},
        Case{"missing", "  xyz_m: [0, 0, 0.9]\n  length_m: 3", "  @xyz_m: [0, 0, 0.9]",
             "conveyor.length_m", "found nothing, expected a number in (0, 1000]"},
        Case{"missing_map", "    peg: {radius_m: 0.0038, height_m: 0.0165}\n", "",
             "gear_types.wheel.peg",
             "found nothing, expected a map with the keys radius_m, height_m", "disc: {"}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Types, SceneErrors,
    testing::Values(
        Case{"text_for_number", "length_m: 3", "length_m: @long", "conveyor.length_m",
             "found \"long\", expected a number in (0, 1000]"},
        Case{"quoted_number", "length_m: 3", "length_m: @'3'", "conveyor.length_m",
             "found \"3\", expected a number in (0, 1000]"},
        Case{"list_for_number", "length_m: 3", "length_m: @[3]", "conveyor.length_m",
             "found a list, expected a number in (0, 1000]"},
        Case{"nothing_for_number", "length_m: 3", "length_m: @~", "conveyor.length_m",
             "found nothing, expected a number in (0, 1000]"},
        Case{"not_finite", "length_m: 3", "length_m: @.inf", "conveyor.length_m",
             "found \".inf\", expected a number in (0, 1000]"},
        Case{"overflow", "length_m: 3", "length_m: @1e999", "conveyor.length_m",
             "found \"1e999\", expected a number in (0, 1000]"},
        Case{"number_for_map", "friction: {gear_tray: 0.4}", "friction: @0.4", "physics.friction",
             "found 0.4, expected a map with the keys gear_tray, gear_gear, gear_ground, "
             "tray_belt, tray_ground, tray_tray, robot"},
        Case{"map_for_list", "robots:\n  - name: robbie\n    type: arm\n",
             "robots:\n    @name: robbie\n    type: arm\n", "robots",
             "found a map, expected a list"},
        Case{"short_list", "xy_m: [0.2, 1]", "xy_m: @[0.2]", "trays[0].xy_m",
             "found a list of 1, expected a list of 2 numbers"},
        Case{"text_in_list", "xy_m: [0.2, 1]", "xy_m: [0.2, @one]", "trays[0].xy_m[1]",
             "found \"one\", expected a number in [-1000, 1000]"},
        Case{"fraction_for_whole", "seed: 7", "seed: @7.5", "seed",
             "found 7.5, expected a whole number >= 0"},
        Case{"word_for_flag", "floor: true", "floor: @yes", "floor",
             "found \"yes\", expected true or false"},
        Case{"unknown_word", "law: linkage", "law: @linkages", "robot_types.arm.gripper.law",
             "found \"linkages\", expected one of linkage, coupled, mimic_pid, constant (did you "
             "mean linkage?)"},
        Case{"servo_law", "law: linkage", "law: coupled\n      drive: @servo",
             "robot_types.arm.gripper.drive",
             "found a servo with a law of pistons, expected law linkage or constant with it"},
        Case{"simplification", "simplification: off", "simplification: @asleep",
             "physics.simplification",
             "found \"asleep\", expected one of off, virtual_joints, merge, dormant"},
        Case{"name_of_the_frame", "name: second", "name: @world", "trays[1].name",
             "found \"world\", expected another name, as \"world\" is the cell's own frame"},
        Case{"bad_name", "name: second", "name: @'second tray, old'", "trays[1].name",
             "found \"second tray, old\", expected a name of at most 64 letters, digits, '_', '-' "
             "and '.'"}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    CrclJoints, SceneErrors,
    testing::Values(
        Case{"tool_point_word", "self_collision: true", "crcl_tool_point: @palm",
             "robots[0].crcl_tool_point", "found \"palm\", expected one of tool, flange"},
        Case{"server_controller", "self_collision: true",
             "servers: {simple_message: {controller: @karel}}",
             "robots[0].servers.simple_message.controller",
             "found \"karel\", expected one of fanuc_karel, motoman_fs100"},
        Case{"server_port", "self_collision: true",
             "servers: {simple_message: {controller: fanuc_karel, state: @70000}}",
             "robots[0].servers.simple_message.state",
             "found 70000, expected a whole number in [0, 65535]"},
        Case{"server_of_an_arm_with_other_joints", "self_collision: true",
             "servers: {simple_message: {controller: @motoman_fs100}}",
             "robots[0].servers.simple_message.controller",
             "found \"motoman_fs100\", expected the controller of a robot with 6 joints"},
        Case{"planning_word", "self_collision: true", "planning: @detour", "robots[0].planning",
             "found \"detour\", expected one of direct, check, avoid"},
        Case{"clearance", "self_collision: true", "clearance_m: @0.5", "robots[0].clearance_m",
             "found 0.5, expected a number in [0, 0.2]"},
        Case{"out_of_range_word", "self_collision: true", "crcl_out_of_range: @ignore",
             "robots[0].crcl_out_of_range", "found \"ignore\", expected one of refuse, clamp"},
        Case{"too_few", "self_collision: true", "crcl_joints: @[{joint: 1}]",
             "robots[0].crcl_joints", "found a list of 1, expected a list of 6 to 8 joints"},
        Case{"no_such_joint", "self_collision: true",
             "crcl_joints: [{joint: @7}, {joint: 2}, {joint: 3}, {joint: 4}, {joint: 5}, {joint: "
             "6}]",
             "robots[0].crcl_joints[0].joint",
             "found 7, expected a joint of the model, 1 to 6, or none"},
        Case{"joint_twice", "self_collision: true",
             "crcl_joints: [{joint: 1}, @{joint: 1}, {joint: 3}, {joint: 4}, {joint: 5}, {joint: "
             "6}]",
             "robots[0].crcl_joints[1]", "found joint 1 a second time, expected each joint once"},
        Case{"joint_missing", "self_collision: true",
             "crcl_joints: @[{joint: 1}, {joint: none}, {joint: 3}, {joint: 4}, {joint: 5}, "
             "{joint: 6}]",
             "robots[0].crcl_joints", "found no joint 2, expected each joint of the model once"},
        Case{"unused_with_more", "self_collision: true",
             "crcl_joints: [{joint: none, reversed: @true}, {joint: 1}, {joint: 2}, {joint: 3}, "
             "{joint: 4}, {joint: 5}, {joint: 6}]",
             "robots[0].crcl_joints[0].reversed",
             "found reversed of joint none, expected the key joint alone"},
        Case{"no_pulses", "self_collision: true",
             "crcl_joints: [{joint: 1, pulses_per_deg: @0}, {joint: 2}, {joint: 3}, {joint: 4}, "
             "{joint: 5}, {joint: 6}]",
             "robots[0].crcl_joints[0].pulses_per_deg", "found 0, expected a number in (0, 1e+09]"},
        Case{
            "coupled_to_itself", "self_collision: true",
            "crcl_joints: [{joint: 1, coupling: {1: @1}}, {joint: 2}, {joint: 3}, {joint: 4}, "
            "{joint: 5}, {joint: 6}]",
            "robots[0].crcl_joints[0].coupling.1",
            "found a coupling to \"1\", expected the number of another joint of this list, 1 to 6"},
        Case{"coupled_to_none", "self_collision: true",
             "crcl_joints: [@{joint: 1, coupling: {7: 1}}, {joint: 2}, {joint: 3}, {joint: 4}, "
             "{joint: 5}, {joint: 6}, {joint: none}]",
             "robots[0].crcl_joints[0]",
             "found a coupling to joint 7, which is none, expected couplings to joints of the "
             "model"},
        Case{"couplings_cancel", "self_collision: true",
             "crcl_joints: @[{joint: 1, coupling: {2: 1}}, {joint: 2, coupling: {1: 1}}, {joint: "
             "3}, "
             "{joint: 4}, {joint: 5}, {joint: 6}]",
             "robots[0].crcl_joints",
             "found couplings that cancel each other, expected joints that each move the arm on "
             "their own"},
        Case{"limits_swapped", "self_collision: true",
             "crcl_joints: [{joint: 1, limits: @[5, -5]}, {joint: 2}, {joint: 3}, {joint: 4}, "
             "{joint: 5}, {joint: 6}]",
             "robots[0].crcl_joints[0].limits",
             "found a lower limit not below the upper, expected [LOWER, UPPER]"},
        Case{"gripper_name", "self_collision: true", "gripper_names: [@'two jaws']",
             "robots[0].gripper_names[0]",
             "found \"two jaws\", expected a name of at most 64 letters, digits, '_', '-' and "
             "'.'"}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Ranges, SceneErrors,
    testing::Values(
        Case{"belt_speed", "max_speed_m_s: 0.3", "max_speed_m_s: @-1", "conveyor.max_speed_m_s",
             "found -1, expected a number > 0"},
        Case{"belt_braking", "max_accel_m_s2: 0.5", "max_accel_m_s2: 0.5\n  max_decel_m_s2: @0",
             "conveyor.max_decel_m_s2", "found 0, expected a number > 0"},
        Case{"belt_emergency_braking", "max_accel_m_s2: 0.5",
             "max_accel_m_s2: 0.5\n  emergency_decel_m_s2: @0.4", "conveyor.emergency_decel_m_s2",
             "found 0.4, expected a number >= 0.5"},
        Case{"photo_eye_off_the_belt", "max_accel_m_s2: 0.5",
             "max_accel_m_s2: 0.5\n  photo_eyes:\n  - {name: a, height_m: 0.01, x_m: @1.6}",
             "conveyor.photo_eyes[0].x_m", "found 1.6, expected a number in [-1.5, 1.5]"},
        Case{"photo_eye_in_the_belt", "max_accel_m_s2: 0.5",
             "max_accel_m_s2: 0.5\n  photo_eyes:\n  - {name: a, x_m: 0, height_m: @0}",
             "conveyor.photo_eyes[0].height_m", "found 0, expected a number in (0, 1000]"},
        Case{"step", "step_s: 0.001", "step_s: @0.01", "physics.step_s",
             "found 0.01, expected a number in (0, 0.002]"},
        Case{"residual", "step_s: 0.001", "step_s: 0.001\n  residual_m_s: @0.01",
             "physics.residual_m_s", "found 0.01, expected a number in [1e-08, 0.001]"},
        Case{"engine", "step_s: 0.001", "step_s: 0.001\n  engine: @bullet", "physics.engine",
             "found \"bullet\", expected one of aprsim, ode"},
        Case{"ode_without_its_engine", "step_s: 0.001", "step_s: 0.001\n  ode: @{iterations: 20}",
             "physics.ode",
             "found settings of ODE with the engine aprsim, expected engine: ode with them"},
        Case{"ode_iterations", "step_s: 0.001",
             "step_s: 0.001\n  engine: ode\n  ode: {iterations: @0}", "physics.ode.iterations",
             "found 0, expected a whole number in [1, 10000]"},
        Case{"restitution", "restitution: {gear_ground: 0.3}", "restitution: {gear_ground: @1.5}",
             "physics.restitution.gear_ground", "found 1.5, expected a number in [0, 1]"},
        Case{"rolling_resistance", "rolling_resistance_mm: {gear_ground: 0.1}",
             "rolling_resistance_mm: {gear_ground: @20}",
             "physics.rolling_resistance_mm.gear_ground", "found 20, expected a number in [0, 10]"},
        Case{"seed", "seed: 7", "seed: @-7", "seed", "found -7, expected a whole number >= 0"},
        Case{"friction", "gear_tray: 0.4", "gear_tray: @-0.1", "physics.friction.gear_tray",
             "found -0.1, expected a number >= 0"},
        Case{"gear_mass", "mass_kg: 0.01", "mass_kg: @0", "gear_types.wheel.mass_kg",
             "found 0, expected a number > 0"},
        Case{"tray_mass", "mass_kg: 0.2", "mass_kg: @-2", "tray_types.plate.mass_kg",
             "found -2, expected a number > 0"},
        Case{"table_size", "size_m: [1, 0.5, 0.1]", "size_m: [1, @0, 0.1]", "fixed[0].size_m[1]",
             "found 0, expected a number in (0, 1000]"},
        Case{"angle_of_a_seated_gear", "left: wheel_1", "left: {name: wheel_1, yaw_deg: @-400}",
             "trays[0].gears.left.yaw_deg", "found -400, expected a number in [-360, 360]"},
        Case{"angle", "yaw_deg: 90", "yaw_deg: @900", "trays[0].yaw_deg",
             "found 900, expected a number in [-360, 360]"},
        Case{"joints", "home_deg: [0, 0, 0, 0, -90, 0]", "home_deg: @[0, 0, 0, 0, 0, 0, 0, 0]",
             "robot_types.arm.home_deg", "found a list of 8, expected a list of 1 to 7 numbers"}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Sense, SceneErrors,
    testing::Values(
        Case{"gap", "gap_open_m: 0.02", "gap_open_m: @0.005", "robot_types.arm.gripper.gap_open_m",
             "found 0.005, expected a number > 0.005"},
        Case{"stroke", "stroke_m: 0.0075", "stroke_m: @0.01", "robot_types.arm.gripper.stroke_m",
             "found 0.01, expected half of gap_open_m - gap_closed_m, 0.007500"},
        Case{"no_force", "      force_n: 60\n", "", "robot_types.arm.gripper.force_n",
             "found nothing, expected a number > 0", "law: linkage"},
        Case{"force_twice", "force_n: 60",
             "force_n: @60\n      pneumatics: {supply_bar: 6, piston_area_mm2: 100}",
             "robot_types.arm.gripper.force_n",
             "found force_n beside pneumatics, expected one of the two"},
        Case{"supply", "force_n: 60", "pneumatics: {supply_bar: @21, piston_area_mm2: 100}",
             "robot_types.arm.gripper.pneumatics.supply_bar",
             "found 21, expected a number in (0, 20]"},
        Case{"friction_eats_force", "force_n: 60",
             "pneumatics: {supply_bar: 6, piston_area_mm2: 100, friction_n: @61}",
             "robot_types.arm.gripper.pneumatics.friction_n",
             "found a friction of 61.000000 N, expected less than the piston's force of 60.000000 "
             "N"},
        Case{"leak_without_filling", "force_n: 60",
             "pneumatics: {supply_bar: 6, piston_area_mm2: 100, leak_per_s: @1}",
             "robot_types.arm.gripper.pneumatics.leak_per_s",
             "found a leak without fill_time_s, expected fill_time_s above 0: a chamber that fills "
             "at "
             "once never loses air"},
        Case{"mimic_gain", "law: linkage", "law: mimic_pid\n      mimic_pid: {p_n_m: @-1}",
             "robot_types.arm.gripper.mimic_pid.p_n_m", "found -1, expected a number >= 0"},
        Case{"groove", "pad: v\n", "pad: v\n      v_depth_m: @0.011\n",
             "robot_types.arm.gripper.v_depth_m", "found 0.011, expected a number in [0, 0.01]"},
        Case{"pocket_too_deep", "depth_m: 0.0125}", "depth_m: 0.017}", "tray_types.plate.slots[0]",
             "found slot left with a pocket 17 mm deep, expected less than the tray's thickness of "
             "17 mm",
             "{name: left"},
        Case{"floor_wider_than_mouth", "floor_radius_m: 0.01", "floor_radius_m: @0.02",
             "pockets.hole.floor_radius_m", "found 0.02, expected a number in (0, 0.0172]"},
        Case{
            "hub_too_wide", "top_radius_m: 0.017,", "top_radius_m: 0.0173,",
            "tray_types.plate.slots[0]",
            "found slot left of gear type wheel with a hub radius of 17.3 mm at the disc, expected "
            "at most the pocket's 17.2 mm",
            "{name: left"},
        Case{"hub_too_wide_below", "bottom_radius_m: 0.0100718", "bottom_radius_m: 0.0104",
             "tray_types.plate.slots[0]",
             "found slot left of gear type wheel with a hub radius of 10.4 mm at its lower end, "
             "expected at most the pocket's 10.29 mm there",
             "{name: left"},
        Case{"hub_too_high", "height_m: 0.012,", "height_m: 0.013,", "tray_types.plate.slots[0]",
             "found slot left of gear type wheel with a hub 13 mm high, expected at most the "
             "pocket's depth of 12.5 mm",
             "{name: left"},
        Case{"disc_falls_in", "top_radius_m: 0.0172", "top_radius_m: 0.0237",
             "tray_types.plate.slots[0]",
             "found slot left of gear type wheel with a disc radius of 23.7 mm, expected more than "
             "the mouth radius of 23.7 mm, so that the disc rests on the tray",
             "{name: left"},
        Case{
            "pocket_over_edge", "xy_m: [-0.03, 0]", "xy_m: [-0.05, 0]", "tray_types.plate.slots[0]",
            "found slot left with a mouth radius of 17.2 mm, expected less than the 16 mm from its "
            "centre to the tray's edge",
            "{name: left"},
        Case{"pockets_meet", "xy_m: [0.03, 0]", "xy_m: [0.004, 0]", "tray_types.plate.slots[1]",
             "found slots left and right 34 mm apart, expected more than the sum of their mouth "
             "radii, 34.4 mm",
             "{name: right"},
        Case{"slab_inside_out", "max_xy_m: [0.066, 0.066]", "max_xy_m: @[-0.066, -0.067]",
             "tray_types.plate.max_xy_m",
             "found a corner not beyond min_xy_m, expected x and y larger than those of min_xy_m"},
        Case{"outline_clockwise", "min_xy_m: [-0.066, -0.066]\n    max_xy_m: [0.066, 0.066]",
             "outline_m: @[[-0.07, -0.07], [-0.07, 0.07], [0.07, 0.07], [0.07, -0.05]]",
             "tray_types.plate.outline_m",
             "found corners in clockwise order, expected the corners counter-clockwise, seen from "
             "above"},
        Case{"outline_with_a_notch", "min_xy_m: [-0.066, -0.066]\n    max_xy_m: [0.066, 0.066]",
             "outline_m: @[[-0.07, -0.07], [0, -0.06], [0.07, -0.07], [0.07, 0.07], [-0.07, 0.07]]",
             "tray_types.plate.outline_m",
             "found corner 1 that does not turn left, expected a convex outline without straight "
             "corners"},
        Case{"outline_with_a_straight_corner",
             "min_xy_m: [-0.066, -0.066]\n    max_xy_m: [0.066, 0.066]",
             "outline_m: @[[-0.07, -0.07], [0, -0.07], [0.07, -0.07], [0.07, 0.07], [-0.07, 0.07]]",
             "tray_types.plate.outline_m",
             "found corner 1 that does not turn left, expected a convex outline without straight "
             "corners"},
        Case{"outline_around_twice", "min_xy_m: [-0.066, -0.066]\n    max_xy_m: [0.066, 0.066]",
             "outline_m: @[[0, 0.2], [-0.12, -0.16], [0.19, 0.06], [-0.19, 0.06], [0.12, -0.16]]",
             "tray_types.plate.outline_m",
             "found an outline that winds around more than once, expected each corner once"},
        Case{"outline_of_two_corners", "min_xy_m: [-0.066, -0.066]\n    max_xy_m: [0.066, 0.066]",
             "outline_m: @[[-0.07, -0.07], [0.07, -0.07]]", "tray_types.plate.outline_m",
             "found 2 corners, expected 3 to 24 corners [x, y]"},
        Case{"outline_corner_twice", "min_xy_m: [-0.066, -0.066]\n    max_xy_m: [0.066, 0.066]",
             "outline_m: @[[-0.07, -0.07], [0.07, -0.07], [0.07, -0.07], [0, 0.07]]",
             "tray_types.plate.outline_m",
             "found corner 2 0 mm from the one before, expected at least 0.1 mm between"},
        Case{"outline_of_no_number", "min_xy_m: [-0.066, -0.066]\n    max_xy_m: [0.066, 0.066]",
             "outline_m: [[-0.07, -0.07], [@.nan, -0.07], [0, 0.07]]",
             "tray_types.plate.outline_m[1][0]",
             "found \".nan\", expected a number in [-1000, 1000]"},
        Case{"outline_beside_rectangle", "thickness_m: 0.017",
             "thickness_m: 0.017\n    outline_m: [[-0.07, -0.07], [0.07, -0.07], [0, 0.07]]",
             "tray_types.plate.min_xy_m",
             "found min_xy_m, max_xy_m and outline_m, expected "
             "outline_m alone",
             "[-0.066, -0.066]"},
        Case{"label_wider_than_tray", "mass_kg: 0.2\n",
             "mass_kg: 0.2\n    label: @{size_m: 0.14, depth_m: 0.001}\n", "tray_types.plate.label",
             "found a label of 140 mm, expected one within the tray's top face"},
        Case{"hub_widens", "bottom_radius_m: 0.0100718", "bottom_radius_m: 0.018",
             "gear_types.wheel",
             "found a hub that widens downwards to 18 mm, expected hub.bottom_radius_m at most "
             "hub.top_radius_m, 17 mm",
             "disc: {"},
        Case{"hub_wider_than_disc", "disc: {radius_m: 0.0237,", "disc: {radius_m: 0.017,",
             "gear_types.wheel",
             "found a hub radius of 17 mm, expected less than the disc's radius, 17 mm", "disc: {"},
        Case{"peg_wider_than_disc", "peg: {radius_m: 0.0038,", "peg: {radius_m: 0.03,",
             "gear_types.wheel",
             "found a peg radius of 30 mm, expected less than the disc's radius, 23.7 mm",
             "disc: {"},
        Case{"chamfer_over_hub", "chamfer_m: 0.0003", "chamfer_m: 0.011", "gear_types.wheel",
             "found a hub chamfer of 11 mm, expected at most the hub's height and lower radius",
             "disc: {"}),
    [](const auto& test) { return test.param.name; });

#define CURTAIN "light_curtain: {xyz_m: [-1, -1, 0.5], beams: 8, pitch_m: 0.04, range_m: 2"
INSTANTIATE_TEST_SUITE_P(
    LightCurtain, SceneErrors,
    testing::Values(
        Case{"unknown_key", "seed: 7", CURTAIN ", @pich_m: 1}", "light_curtain.pich_m",
             "found an unknown key, expected one of xyz_m, rpy_deg, beams, pitch_m, range_m, "
             "reaction (did you mean pitch_m?)"},
        Case{"no_beams", "seed: 7",
             "light_curtain: {xyz_m: [-1, -1, 0.5], beams: @0, pitch_m: 0.04, range_m: 2}",
             "light_curtain.beams", "found 0, expected a whole number in [1, 64]"},
        Case{"too_many_beams", "seed: 7",
             "light_curtain: {xyz_m: [-1, -1, 0.5], beams: @65, pitch_m: 0.04, range_m: 2}",
             "light_curtain.beams", "found 65, expected a whole number in [1, 64]"},
        Case{"no_pitch", "seed: 7",
             "light_curtain: {xyz_m: [-1, -1, 0.5], beams: 8, pitch_m: @0, range_m: 2}",
             "light_curtain.pitch_m", "found 0, expected a number in (0, 1]"},
        Case{"no_range", "seed: 7", "light_curtain: @{xyz_m: [-1, -1, 0.5], beams: 8, pitch_m: 1}",
             "light_curtain.range_m", "found nothing, expected a number in (0, 100]"},
        Case{"reaction", "seed: 7", CURTAIN ", reaction: @stop}", "light_curtain.reaction",
             "found \"stop\", expected one of none, belt_stop, protective_stop, all"},
        Case{"through_the_table", "seed: 7",
             "light_curtain: {xyz_m: @[-1, 1, 0.5], beams: 12, pitch_m: 0.04, range_m: 2}",
             "light_curtain.xyz_m",
             "found beam 9 blocked by table, expected beams clear of everything fixed"},
        Case{"through_the_belt", "seed: 7",
             "light_curtain: {xyz_m: @[0, 0, 0.5], rpy_deg: [0, -90, 0], beams: 1, pitch_m: 0.04, "
             "range_m: 2}",
             "light_curtain.xyz_m",
             "found beam 1 blocked by the belt, expected beams clear of everything fixed"},
        Case{"below_the_floor", "seed: 7",
             "light_curtain: {xyz_m: @[-1, -1, -0.05], beams: 8, pitch_m: 0.04, range_m: 2}",
             "light_curtain.xyz_m",
             "found beam 1 blocked by the floor, expected beams clear of everything fixed"}),
    [](const auto& test) { return test.param.name; });
#undef CURTAIN

INSTANTIATE_TEST_SUITE_P(
    References, SceneErrors,
    testing::Values(
        Case{"tray_type", "type: plate\n    on: conveyor", "type: @plat\n    on: conveyor",
             "trays[1].type",
             "found no tray type \"plat\", expected one of plate (did you mean plate?)"},
        Case{"gear_type", "{name: left, gear: wheel,", "{name: left, gear: @gear,",
             "tray_types.plate.slots[0].gear",
             "found no gear type \"gear\", expected one of wheel"},
        Case{"pocket", "pocket: hole, xy_m: [-0.03", "pocket: @whole, xy_m: [-0.03",
             "tray_types.plate.slots[0].pocket",
             "found no pocket \"whole\", expected one of hole (did you mean hole?)"},
        Case{"key_of_a_seated_gear", "left: wheel_1", "left: {name: wheel_1, @yaw_dge: 20}",
             "trays[0].gears.left.yaw_dge",
             "found an unknown key, expected one of name, yaw_deg (did you mean yaw_deg?)"},
        Case{"slot", "gears: {left: wheel_1}", "gears: {lefty: @wheel_1}", "trays[0].gears.lefty",
             "found no slot \"lefty\", expected one of left, right (did you mean left?)"},
        Case{"robot_type", "    type: arm\n", "    type: @leg\n", "robots[0].type",
             "found no robot type \"leg\", expected one of arm"},
        Case{"support", "on: conveyor", "on: @conveyer", "trays[1].on",
             "found no support \"conveyer\", expected one of conveyor, floor, table (did you mean "
             "conveyor?)"},
        Case{"robot", "reachable_by: [robbie]", "reachable_by: [@bobbie]",
             "trays[0].reachable_by[0]",
             "found no robot \"bobbie\", expected one of robbie (did you mean robbie?)"},
        Case{"beside_support", "xy_m: [0.2, 1]", "xy_m: @[0.2, 2]", "trays[0].xy_m",
             "found a tray whose middle is beside table, expected it above"},
        Case{"two_places", "    on: conveyor\n", "    on: conveyor\n    xyz_m: @[0, 0, 1]\n",
             "trays[1].xyz_m",
             "found a place in the world, expected xy_m and yaw_deg, as \"on\" "
             "is given"},
        Case{"place_without_support", "    on: conveyor\n    xy_m: [-0.5, 0]",
             "    xy_m: @[-0.5, 0]", "trays[1].xy_m",
             "found a place on a support, expected the key \"on\" beside it, or xyz_m and rpy_deg "
             "instead"}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Names, SceneErrors,
    testing::Values(Case{"tray_twice", "name: second", "name: @first", "trays[1].name",
                         "found a second body first, expected unique names"},
                    Case{"gear_as_tray", "left: wheel_1", "left: @first", "trays[0].gears.left",
                         "found a second body first, expected unique names"},
                    Case{"gear_twice", "name: wheel_2", "name: @wheel_1", "gears[0].name",
                         "found a second body wheel_1, expected unique names"},
                    Case{"slot_twice", "- {name: right,", "- @{name: left,",
                         "tray_types.plate.slots[1]",
                         "found a second slot left, expected unique slot names"},
                    Case{"reserved", "{name: table,", "{name: @floor,", "fixed[0].name",
                         "found \"floor\", expected a name other than conveyor and floor"}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Overlaps, SceneErrors,
    testing::Values(
        Case{"tray_in_tray",
             "  - name: second\n    type: plate\n    on: conveyor\n    xy_m: [-0.5, 0]",
             "  - @name: second\n    type: plate\n    on: table\n    xy_m: [0.32, 1]", "trays[1]",
             "found second 12.0 mm deep in first, expected objects apart or touching (0.1 mm "
             "allowed)"},
        Case{"gear_in_gear", "xyz_m: [-0.2, 1, 0.912]}\n",
             "xyz_m: [-0.2, 1, 0.912]}\n  - @{name: wheel_3, type: wheel, xyz_m: [-0.16, 1, "
             "0.912]}\n",
             "gears[1]",
             "found wheel_3 6.0 mm deep in wheel_2, expected objects apart or touching (0.1 mm "
             "allowed)"},
        Case{"tray_in_table", "    on: conveyor\n    xy_m: [-0.5, 0]",
             "    xyz_m: [-0.3, 1, 0.912]", "trays[1]",
             "found second 5.0 mm deep in table, expected objects apart or touching (0.1 mm "
             "allowed)",
             "name: second"},
        Case{"gear_in_tray", "{name: wheel_2, type: wheel, xyz_m: [-0.2, 1, 0.912]}",
             "@{name: wheel_2, type: wheel, xyz_m: [0.2, 1.05, 0.917]}", "gears[0]",
             "found wheel_2 12.0 mm deep in first, expected objects apart or touching (0.1 mm "
             "allowed)"},
        Case{"gear_in_belt", "{name: wheel_2, type: wheel, xyz_m: [-0.2, 1, 0.912]}",
             "@{name: wheel_2, type: wheel, xyz_m: [0.3, 0, 0.9115]}", "gears[0]",
             "found wheel_2 0.5 mm deep in the conveyor's belt, expected objects apart or "
             "touching (0.1 mm allowed)"},
        Case{"gear_in_floor", "{name: wheel_2, type: wheel, xyz_m: [-0.2, 1, 0.912]}",
             "@{name: wheel_2, type: wheel, xyz_m: [2, 0, 0.01]}", "gears[0]",
             "found wheel_2 2.0 mm deep in the floor, expected objects apart or touching (0.1 mm "
             "allowed)"}),
    [](const auto& test) { return test.param.name; });

// A cup on the robot of the small scene, or in a holder.
#define APRSIM_CUP(KIND, POINT, RADIUS)                                                        \
  "tools:\n  - name: cup\n    kind: " KIND "\n    tool_point: {xyz_m: " POINT                  \
  "}\n    cup: {radius_m: " RADIUS                                                             \
  ", length_m: 0.03, max_vacuum_kpa: 60, free_flow_l_min: 10, body_size_m: [0.05, 0.05, 0.04]" \
  ", body_mass_kg: 0.2}\n"
#define APRSIM_GOOD_CUP APRSIM_CUP("vacuum_cup", "[0, 0, 0.1]", "0.01")
#define APRSIM_HOLDER(SEAT, TOOL)                                                      \
  "holders:\n  - {name: fork, xyz_m: [1, 0, 0.5], rpy_deg: [180, 0, 0], seat_m: " SEAT \
  ", gap_m: 0.03, bar_m: [0.02, 0.06, 0.02], tool: " TOOL "}\n"

INSTANTIATE_TEST_SUITE_P(
    Tools, SceneErrors,
    testing::Values(
        Case{"nowhere", "floor: true\n", APRSIM_GOOD_CUP "floor: true\n", "tools[0]",
             "found tool cup on no robot and in no holder, expected a robot or a holder with the "
             "key tool: cup",
             "name: cup"},
        Case{"kind", "floor: true\n", APRSIM_CUP("@spoon", "[0, 0, 0.1]", "0.01") "floor: true\n",
             "tools[0].kind", "found \"spoon\", expected one of pincher, vacuum_cup"},
        Case{"radius", "floor: true\n",
             APRSIM_CUP("vacuum_cup", "[0, 0, 0.1]", "@0") "floor: true\n", "tools[0].cup.radius_m",
             "found 0, expected a number in (0, 1000]"},
        Case{"aside", "floor: true\n",
             APRSIM_CUP("vacuum_cup", "[0.01, 0, 0.1]", "0.01") "floor: true\n",
             "tools[0].tool_point",
             "found a tool point beside the coupling's axis, expected x and y of xyz_m 0, and a "
             "turn about z only",
             "{xyz_m: [0.01, 0, 0.1]"},
        Case{"too_short", "floor: true\n",
             APRSIM_CUP("vacuum_cup", "@[0, 0, 0.05]", "0.01") "floor: true\n",
             "tools[0].tool_point.xyz_m",
             "found a palm that reaches beyond the coupling, expected z at least pad_height_m and "
             "the palm's height, 0.070000"},
        Case{"unknown", "    self_collision: true\n",
             "    self_collision: true\n    tool: @spoon\n", "robots[0].tool",
             "found no tool \"spoon\", expected one that is defined (there is none)"},
        Case{"twice", "    self_collision: true\n",
             "    self_collision: true\n    tool: cup\n" APRSIM_GOOD_CUP APRSIM_HOLDER("0.07",
                                                                                       "@cup"),
             "holders[0].tool",
             "found tool cup in a second place, expected each tool on one robot or in one holder"},
        Case{"seat", "floor: true\n",
             APRSIM_GOOD_CUP APRSIM_HOLDER("@0.075", "cup") "floor: true\n", "holders[0].seat_m",
             "found 0.075, expected the distance of cup's palm from its coupling, 0.070000, within "
             "1 mm"},
        Case{"changer", "    self_collision: true\n",
             "    self_collision: true\n    tool_changer: {xyz_m: [0, 0, 0], capture_m: @0.1}\n",
             "robots[0].tool_changer.capture_m", "found 0.1, expected a number in [0, 0.02]"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace aprsim::scene
