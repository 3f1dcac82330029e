"""Delay of guards, relaxation of the gripper's mount and errors of the force sensor, in a cell of this process:
a closed gripper comes down on a gear until a guard stops it."""

import math
import pathlib
import shutil
import tempfile
import unittest

import numpy as np

from aprsim import World
from aprsim.poses import tool_down

GUARD_N = 2
MOVE = """<CRCLCommandInstance xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
<CRCLCommand xsi:type="MoveToType"><CommandID>1000</CommandID><Guard><Name>down</Name>
<SensorID>force_torque</SensorID><SubField>Fz</SubField><LimitType>INCREASE_OVER_LIMIT</LimitType>
<LimitValue>{limit}</LimitValue><RecheckTimeMicroSeconds>0</RecheckTimeMicroSeconds></Guard>
<MoveStraight>true</MoveStraight><EndPosition><Point><X>{x!r}</X><Y>{y!r}</Y><Z>{z!r}</Z></Point>
<XAxis><I>{xi!r}</I><J>{xj!r}</J><K>{xk!r}</K></XAxis><ZAxis><I>{zi!r}</I><J>{zj!r}</J><K>{zk!r}</K></ZAxis>
</EndPosition></CRCLCommand></CRCLCommandInstance>"""


class Pressed:
    """Time, height of the tool and force along z, each 2 ms, of one press."""

    def __init__(self, folder, robot="", gripper="pad_friction: 0.8"):
        scene = pathlib.Path(folder) / "press.yaml"
        scene.write_text(
            f"base: aprs\nrobots:\n- {{name: fanuc{robot}}}\n"
            f"robot_types: {{fanuc_lrmate200id: {{gripper: {{{gripper}}}}}}}\n",
            encoding="utf-8",
        )
        with World(str(scene)) as world:
            fanuc = world.robot("fanuc")
            fanuc.close_gripper()
            gear = world.snapshot().body("part_large_gear_1").position_m
            fanuc.move_to(tool_down(gear + np.array([0, 0, 0.05]), 0))
            fanuc.set_speed(0.02)
            tool = fanuc.tool("robot")
            x, y, z = (1000 * tool[:3, 3]).tolist()
            (xi, xj, xk), (zi, zj, zk) = tool[:3, 0].tolist(), tool[:3, 2].tolist()
            text = MOVE.format(limit=GUARD_N, x=x, y=y, z=z - 60, xi=xi, xj=xj, xk=xk, zi=zi, zj=zj, zk=zk)
            fanuc._wire.send(text.encode())
            self.samples = np.empty((3500, 3))
            for sample in self.samples:
                world.advance(2)
                sample[:] = world.step_count * 1e-3, world.tool_poses[0, 2], world.tool_loads[0, 2]
            self.state_hash = world.state_hash
            self.description = world.snapshot().robot("fanuc").alarm

    @property
    def stopped(self):
        """Index of the first sample at the last height."""
        return int(np.argmax(np.abs(self.samples[:, 1] - self.samples[-1, 1]) < 1e-6))


class PressTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.plain = Pressed(cls.folder)

    def test_a_guard_stops_the_robot_after_its_delay(self):
        late = Pressed(self.folder, ", guard_delay_s: 0.04")
        self.assertGreater(self.plain.samples[-1, 2], GUARD_N)
        delay = late.samples[late.stopped, 0] - self.plain.samples[self.plain.stopped, 0]
        self.assertAlmostEqual(delay, 0.04, delta=0.002)
        # 40 ms at 20 mm/s deeper, against 5000 N/m.
        self.assertAlmostEqual(self.plain.samples[-1, 1] - late.samples[-1, 1], 0.8e-3, delta=2e-5)
        self.assertAlmostEqual(late.samples[-1, 2] - self.plain.samples[-1, 2], 4, delta=0.3)
        self.assertEqual(late.description, "")

    def test_a_held_force_relaxes_by_its_share_in_its_time(self):
        soft = Pressed(self.folder, "", "palm_relaxation: {share: 0.15, time_s: 2}")
        # The arm yields a little and returns, in both alike.
        share = soft.samples[:, 2] / np.where(self.plain.samples[:, 2] > 0.5, self.plain.samples[:, 2], np.inf)
        stop = soft.stopped
        self.assertAlmostEqual(share[stop], 1, delta=0.01)
        for seconds in (0.5, 1.0, 2.0):
            expected = 1 - 0.15 * (1 - math.exp(-seconds / 2))
            self.assertAlmostEqual(share[stop + round(500 * seconds)], expected, delta=0.01)

    def test_errors_of_the_sensor_are_read_and_change_no_motion(self):
        biased = Pressed(self.folder, ", force_sensor: {bias_n: [0, 0, -35], drift_n_s: [0, 0, 0.1]}")
        self.assertEqual(biased.state_hash, self.plain.state_hash)
        # The tool's z points down.
        expected = 35 - 0.1 * biased.samples[:, 0] + self.plain.samples[:, 2]
        self.assertLess(np.abs(biased.samples[:, 2] - expected).max(), 1e-3)
        noisy = Pressed(self.folder, ", force_sensor: {noise_n: 0.05}")
        free = noisy.samples[noisy.samples[:, 0] < noisy.samples[0, 0] + 1, 2]
        self.assertAlmostEqual(free.std(), 0.05, delta=0.006)
        self.assertLess(abs(np.corrcoef(free[1:], free[:-1])[0, 1]), 0.15)


if __name__ == "__main__":
    unittest.main()
