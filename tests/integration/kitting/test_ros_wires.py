"""The kitting controller over Simple Message, as the laboratory's ROS 2 controllers command the robots: its
parts, whole jobs in virtual time, and both generations of wires at once."""

import math
import pathlib
import random
import tempfile
import unittest

from random_layouts import SCENES, Layout, fill_kits
from running_cell import BINARIES, Daemon, snapshot
from test_cell import KITS, KittingTest

# On the path that running_cell sets.
import cell as cells
import joint_path
import kinematics

CLOSE_MM = 0.2


class KinematicsTest(unittest.TestCase):
    def setUp(self):
        self.robots = cells.read_cell("aprs_2024").robots

    def test_home_is_where_the_cell_file_says(self):
        for robot in (*self.robots.values(), *cells.read_cell("aprs_2025").robots.values()):
            home = [math.radians(angle) for angle in robot.home_joints_deg]
            (x, y, _), axes = robot.ros.chain.forward(home)
            place = robot.frame.point((1e3 * x, 1e3 * y))
            self.assertLess(math.dist(place, robot.home_mm), 1, robot.name)
            self.assertAlmostEqual(axes[2][2], -1, delta=1e-6)

    def test_joints_bring_the_tool_to_its_place(self):
        chances = random.Random(7)
        for robot in self.robots.values():
            chain = robot.ros.chain
            home = [math.radians(angle) for angle in robot.home_joints_deg]
            for _ in range(40):
                # Nearer, the elbow of the Motoman meets its limit.
                radius = chances.uniform(0.4, robot.reach_mm[1] / 1e3)
                angle, yaw = chances.uniform(-1.5, 1.5), chances.uniform(-math.pi, math.pi)
                place = (radius * math.cos(angle), radius * math.sin(angle), chances.uniform(0.0, 0.1))
                joints = joint_path.goal(chain, home, place, yaw, home)
                self.assertTrue(chain.within_limits(joints))
                at, axes = chain.forward(joints)
                self.assertLess(1e3 * math.dist(at, place), CLOSE_MM)
                for row, wanted in zip(axes, kinematics.tool_down(yaw)):
                    for value, right in zip(row, wanted):
                        self.assertAlmostEqual(value, right, delta=1e-3)

    def test_a_line_is_straight_and_a_course_keeps_to_the_speeds(self):
        chain = self.robots["motoman"].ros.chain
        rest = [math.radians(angle) for angle in self.robots["motoman"].home_joints_deg]
        begin = joint_path.goal(chain, rest, (0.5, -0.3, 0.1), 0.5, rest)
        path = joint_path.line(chain, begin, (0.5, -0.3, 0.04), 0.5, rest)
        for joints in path:
            at, _ = chain.forward(joints)
            self.assertLess(1e3 * math.hypot(at[0] - 0.5, at[1] + 0.3), CLOSE_MM)
        points = joint_path.timed(chain, [begin, *path], 0.3)
        self.assertEqual(points[0].speeds, [0.0] * 7)
        self.assertEqual(points[-1].speeds, [0.0] * 7)
        self.assertEqual(points[-1].joints, path[-1])
        for point in points:
            for joint, speed in zip(chain.joints, point.speeds):
                self.assertLess(abs(speed), 0.35 * joint.speed)

    def test_a_place_out_of_reach_is_refused(self):
        chain = self.robots["fanuc"].ros.chain
        rest = [math.radians(angle) for angle in self.robots["fanuc"].home_joints_deg]
        with self.assertRaises(joint_path.Unreachable):
            joint_path.goal(chain, rest, (1.5, 0.0, 0.1), 0.0, rest)


class JobTest(KittingTest):
    def run_once(self, wires, pacers):
        pacers = f"{pacers},vision.fanuc,vision.motoman"
        self.cell = cells.read_cell("aprs_2024")
        self.daemon = Daemon(
            BINARIES, "--scene", "aprs_2024", "--time", "virtual", "--pacers", pacers, "--no-web"
        )
        self.addCleanup(self.daemon.close)
        controller = self.controller(
            "--cell", "aprs_2024", "--wires", wires, "--clock", "polls", "--poll-ms", "25"
        )
        report = self.assert_done(controller)
        self.assert_kits(full=KITS)
        state = snapshot(self.daemon)
        self.assertTrue(state["virtual_time"]["reproducible"])
        self.daemon.close()
        return state["step"], state["state_hash"], report

    def test_both_robots_fill_all_kits_the_same_way_every_time(self):
        first = self.run_once("simple-message", "gripper.fanuc,gripper.motoman")
        self.assertEqual(first[2]["counts"].get("robot_error", 0), 0)
        again = self.run_once("simple-message", "gripper.fanuc,gripper.motoman")
        self.assertEqual(first[:2], again[:2])

    def test_both_generations_at_once(self):
        _, _, report = self.run_once("fanuc=simple-message,motoman=crcl", "gripper.fanuc,crcl.motoman")
        self.assertGreater(report["robots"]["fanuc"]["crcl"]["point"], 0)
        self.assertGreater(report["robots"]["motoman"]["crcl"]["MoveTo"], 0)

    def test_wires_that_the_cell_lacks_are_refused(self):
        self.start()
        controller = self.controller("--wires", "simple-message")
        out, _ = controller.process.communicate(timeout=60)
        self.assertEqual(controller.process.returncode, 2)
        self.assertIn("no Simple Message ports of fanuc", out)


class LaboratoryTest(unittest.TestCase):
    """The laboratory of 2025, its trays where they were recorded, and at random places."""

    def fill(self, scene, kits):
        code, report, text, wrong, _ = fill_kits(scene, kits)
        self.assertEqual(code, 0, text)
        self.assertEqual(wrong, [], text)
        self.assertEqual(report["counts"].get("robot_error", 0), 0, text)
        return report

    def test_the_recorded_layout(self):
        # One kit lacks its parts, on the Fanuc's side.
        report = self.fill(SCENES / "aprs_2025.yaml", ("m2l1_02", "m2l1_05", "s2l2_05"))
        self.assertEqual(len(report["kits"]), 3)
        self.assertEqual(sum(kit["placed_by"].get("fanuc", 0) for kit in report["kits"]), 3)

    def test_a_random_layout(self):
        layout = Layout(seed=2)
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder) / "scene.yaml"
            scene.write_text(layout.scene(), encoding="utf-8")
            report = self.fill(scene, layout.kits)
        for robot in report["robots"]:
            placed = sum(kit["placed_by"].get(robot, 0) for kit in report["kits"])
            self.assertGreaterEqual(placed, 3, robot)


if __name__ == "__main__":
    unittest.main()
