"""Arms of other geometries: each by its own CRCL port."""

import unittest

import numpy as np
from aprsim import RobotError, crcl
from aprsim.envs.layout import Layout
from aprsim.poses import yaw_of
from running_cell import WithCell

NAMES = ("ur5e", "irb120", "panda", "scara")


class ArmsTest(WithCell):
    arguments = ("--scene", "arms", "--speed", "stepped")

    def test_every_arm_has_its_port_and_moves_straight(self):
        for name in NAMES:
            with self.subTest(name):
                robot = self.cell.robot(name)
                before = robot.tool()
                # Every home posture points down, at the bench.
                self.assertLess(before[2, 2], -1 + 1e-6)
                robot.set_speed(0.3)
                for way in ([0, 0, -0.02], [0.03, 0.02, 0.01], [-0.03, -0.02, 0.01]):
                    robot.move_by(way)
                np.testing.assert_allclose(robot.tool(), before, atol=1e-5)
        self.assertEqual(tuple(self.cell.snapshot().robots), NAMES)

    def test_turns_about_the_vertical(self):
        for name in NAMES:
            with self.subTest(name):
                robot = self.cell.robot(name)
                target = robot.tool()
                angle = 0.4
                c, s = np.cos(angle), np.sin(angle)
                target[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ target[:3, :3]
                robot.move_to(target)
                np.testing.assert_allclose(robot.tool(), target, atol=1e-5)

    def test_joint_moves(self):
        for name in NAMES[:3]:
            with self.subTest(name):
                robot = self.cell.robot(name)
                target = self.cell.snapshot().robot(name).joints_rad + 0.1
                robot.move_joints(target, speed_rad_s=0.5)
                np.testing.assert_allclose(
                    self.cell.snapshot().robot(name).joints_rad, target, atol=1e-5
                )

    def test_the_scaras_stroke_counts_in_millimetres(self):
        scara = self.cell.robot("scara")
        speeds = {1: 30, 2: 30, 3: 20, 4: 30}
        scara.run(crcl.move_joints({1: -30, 2: 80, 3: -70, 4: 10}, speeds))
        np.testing.assert_allclose(
            self.cell.snapshot().robot("scara").joints_rad,
            [np.radians(-30), np.radians(80), -0.07, np.radians(10)],
            atol=1e-5,
        )
        with self.assertRaisesRegex(RobotError, "joint_3 at .* mm is greater than its limit"):
            scara.run(crcl.move_joints({3: 50}, 20))

    def test_the_scara_refuses_a_tilt_with_its_angle(self):
        scara = self.cell.robot("scara")
        target = scara.tool()
        c, s = np.cos(0.1), np.sin(0.1)
        target[:3, :3] = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ target[:3, :3]
        with self.assertRaisesRegex(RobotError, r"tilted by 5\.7\d\d deg"):
            scara.move_to(target)
        scara.initialise()
        scara.move_by([0, 0, 0.02])

    def test_every_arm_picks_a_gear(self):
        for number, name in enumerate(NAMES):
            with self.subTest(name):
                gear_name = f"part_medium_gear_{2 * number + 1}"
                robot = self.cell.robot(name)
                yaw = yaw_of(robot.tool())
                gear = Layout(self.cell.description, self.cell.snapshot()).gears[gear_name]
                grasp = gear.position_m + [0, 0, gear.grasp_height_m]
                above = grasp + [0, 0, 0.06]
                robot.set_speed(0.4)
                robot.open_gripper()
                robot.move_to(above, yaw)
                robot.move_to(grasp, yaw, straight=True)
                robot.close_gripper()
                robot.dwell(0.3)
                robot.move_to(above, yaw, straight=True)
                state = self.cell.snapshot()
                self.assertEqual(state.robot(name).held_body, gear_name)
                lifted = state.body(gear_name).position_m[2] - gear.position_m[2]
                self.assertAlmostEqual(lifted, 0.06, delta=1e-3)


if __name__ == "__main__":
    unittest.main()
