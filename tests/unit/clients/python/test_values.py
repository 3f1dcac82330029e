"""Poses, endpoints, faults, snapshots, spaces and reports of the Python package."""

import json
import math
import os
import pathlib
import tempfile
import unittest
from unittest import mock

import numpy as np
from aprsim import (
    AprsimError,
    Snapshot,
    TimedOut,
    Unreachable,
    bodies_table,
    faults,
    poses,
    robots_table,
)
from aprsim.binaries import find_binary
from aprsim.calls import error_of
from aprsim.endpoints import find_endpoints, read_ports_file
from aprsim.envs.spaces import OwnBox, OwnEnv
from aprsim.scenarios import read_report
from aprsim.v1 import geometry_pb2, snapshot_pb2


class Poses(unittest.TestCase):
    def test_quaternions_and_rotations_are_the_same_turns(self):
        random = np.random.default_rng(5)
        turns = list(random.normal(size=(200, 4)))
        turns += [np.eye(4)[i] + 1e-9 * random.normal(size=4) for i in range(4)]
        for quaternion in turns:
            turn = poses.rotation(quaternion)
            np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
            self.assertAlmostEqual(np.linalg.det(turn), 1.0, places=12)
            again = poses.quaternion(turn)
            self.assertGreaterEqual(again[0], 0)
            self.assertAlmostEqual(abs(again @ quaternion) / np.linalg.norm(quaternion), 1, places=12)

    def test_a_turn_about_z_turns_x_towards_y(self):
        quarter = poses.rotation(np.array([math.sqrt(0.5), 0, 0, math.sqrt(0.5)]))
        np.testing.assert_allclose(quarter @ [1, 0, 0], [0, 1, 0], atol=1e-12)
        pose = geometry_pb2.Pose()
        pose.position_m.y = 2
        np.testing.assert_array_equal(poses.matrix(pose)[:3, :3], np.eye(3), "of no quaternion")
        np.testing.assert_array_equal(poses.matrix(pose)[:3, 3], [0, 2, 0])

    def test_tools_and_inverses(self):
        tool = poses.tool_down([1, 2, 3], 0.4)
        np.testing.assert_allclose(tool[:3, :3] @ tool[:3, :3].T, np.eye(3), atol=1e-12)
        self.assertAlmostEqual(np.linalg.det(tool[:3, :3]), 1)
        np.testing.assert_array_equal(tool[:3, 2], [0, 0, -1])
        self.assertAlmostEqual(poses.yaw_of(tool), 0.4)
        np.testing.assert_allclose(poses.inverse(tool) @ tool, np.eye(4), atol=1e-12)
        self.assertAlmostEqual(poses.wrapped(7 * math.pi / 2), -math.pi / 2)


class Endpoints(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        clean = {k: v for k, v in os.environ.items() if not k.startswith("APRSIM_")}
        patch = mock.patch.dict(os.environ, clean, clear=True)
        patch.start()
        self.addCleanup(patch.stop)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return path

    def test_from_a_ports_file_the_variable_and_single_choices(self):
        self.assertEqual(find_endpoints().crcl, {"fanuc": 64444, "motoman": 64445})
        path = self.write("p", json.dumps({"crcl.arm": 5, "grpc": 6, "modbus": 7, "pid": 1}))
        os.environ["APRSIM_PORTS_FILE"] = str(path)
        found = find_endpoints(host="cell.example", crcl={"other": 9})
        self.assertEqual((found.host, found.grpc), ("cell.example", 6))
        self.assertEqual(found.crcl, {"arm": 5, "other": 9})
        with self.assertRaisesRegex(AprsimError, "no robot 'fanuc'; there is arm, other"):
            found.crcl_port("fanuc")

    def test_a_ports_file_s_mistakes_are_told(self):
        for text, words in (
            ("{", "is not a ports file"),
            ("[]", "is not a ports file: not a JSON object"),
            ('{"grpc": 70000}', '"grpc" is 70000, not a port'),
            ('{"crcl.fanuc": true}', "not a port"),
        ):
            with self.assertRaisesRegex(AprsimError, words):
                read_ports_file(self.write("p", text))
        with self.assertRaisesRegex(AprsimError, "cannot read the ports file"):
            read_ports_file(self.folder / "none")

    def test_tokens_are_never_shown(self):
        path = self.write("t", "secret-token\r\nmore\n")
        found = find_endpoints(token_file=path)
        self.assertEqual(found.token, "secret-token")
        self.assertNotIn("secret", repr(found))
        os.environ["APRSIM_TOKEN"] = "s\u00e9cret"
        with self.assertRaisesRegex(AprsimError, "APRSIM_TOKEN") as caught:
            find_endpoints()
        self.assertNotIn("cret", str(caught.exception))

    def test_errors_of_calls(self):
        self.assertIsInstance(error_of("UNAVAILABLE", "no", "a:1"), Unreachable)
        self.assertIsInstance(error_of("DEADLINE_EXCEEDED", "no", "a:1"), TimedOut)
        refused = error_of("NOT_FOUND", "name: none has it", "a:1")
        self.assertEqual((refused.code, str(refused)), ("NOT_FOUND", "name: none has it"))

    def test_programs_that_are_not_there(self):
        with self.assertRaisesRegex(AprsimError, "no program aprsimd"):
            find_binary("aprsimd", self.folder)


class Faults(unittest.TestCase):
    def test_each_trigger_has_its_message(self):
        for trigger, name in (
            (faults.At(1.25), "at"),
            (faults.Placed("gear", "fanuc"), "placed"),
            (faults.Grasped("fanuc", 3), "grasped"),
            (faults.Beam("downstream"), "beam"),
            (faults.Crossing("tool-force", "fanuc", above=20), "crossing"),
            (faults.Reported("order"), "reported"),
            (None, None),
        ):
            message = faults.request("kind", "fanuc", {"over": 5}, trigger, None)
            self.assertEqual(message.WhichOneof("trigger"), name)
            self.assertFalse(message.HasField("duration"))
        message = faults.request("kind", "", {}, faults.At(1.25), 0)
        self.assertEqual((message.at.seconds, message.at.nanos), (1, 250_000_000))
        self.assertTrue(message.HasField("duration"))

    def test_invalid_arguments(self):
        with self.assertRaisesRegex(AprsimError, "exactly one"):
            faults.request("kind", "", {}, faults.Crossing("tool-force"), None)
        with self.assertRaisesRegex(AprsimError, "duration_s"):
            faults.request("kind", "", {}, None, -1)


class Snapshots(unittest.TestCase):
    def setUp(self):
        message = snapshot_pb2.Snapshot(step=2500)
        message.sim_time.seconds, message.sim_time.nanos = 2, 500_000_000
        for name, x in (("gear", 0.5), ("tray", 0.25)):
            body = message.bodies.add(name=name, type="t", resting=name == "tray")
            body.body_in_world.position_m.x = x
            body.body_in_world.orientation.w = 1
        robot = message.robots.add(name="fanuc")
        for position in (0.1, 0.2):
            robot.joints.add(position_rad=position)
        robot.gripper.held_body = "gear"
        self.snapshot = Snapshot(message)

    def test_arrays(self):
        self.assertEqual(self.snapshot.sim_time_s, 2.5)
        np.testing.assert_array_equal(
            self.snapshot.body_positions_m(), [[0.5, 0, 0], [0.25, 0, 0]]
        )
        self.assertEqual(self.snapshot.body_poses().shape, (2, 4, 4))
        self.assertEqual(Snapshot(snapshot_pb2.Snapshot()).body_poses().shape, (0, 4, 4))
        np.testing.assert_array_equal(self.snapshot.robot("fanuc").joints_rad, [0.1, 0.2])
        self.assertIsNone(self.snapshot.robot("fanuc").held_body, "it does not say it holds it")
        self.assertIsNone(self.snapshot.conveyor)
        with self.assertRaisesRegex(AprsimError, "no body 'x'; there is gear, tray"):
            self.snapshot.body("x")

    def test_tables(self):
        bodies = bodies_table([self.snapshot, self.snapshot])
        self.assertEqual(list(bodies["body"]), ["gear", "tray"] * 2)
        self.assertEqual(list(bodies["x"]), [0.5, 0.25] * 2)
        self.assertEqual(list(bodies["qw"]), [1] * 4)
        self.assertEqual(list(robots_table([self.snapshot])["j2"]), [0.2])
        with mock.patch.dict("sys.modules", {"pandas": None}):
            with self.assertRaisesRegex(AprsimError, "pandas"):
                bodies_table([self.snapshot])


class Spaces(unittest.TestCase):
    def test_a_box_knows_its_own(self):
        box = OwnBox([-1, 0], [1, 2])
        box.seed(3)
        drawn = [box.sample() for _ in range(100)]
        self.assertTrue(all(x in box for x in drawn))
        self.assertGreater(np.std(drawn), 0.3)
        box.seed(3)
        np.testing.assert_array_equal(box.sample(), drawn[0])
        for wrong in (np.array([0, 3]), np.array([0.0]), [0, 1]):
            self.assertNotIn(wrong, box)
        with self.assertRaises(ValueError):
            OwnBox([1], [0])

    def test_seeds_begin_random_numbers_anew(self):
        one, other = OwnEnv(), OwnEnv()
        one.reset(seed=4)
        other.reset(seed=4)
        first = one.np_random.random()
        self.assertEqual(first, other.np_random.random())
        one.reset()
        self.assertNotEqual(first, one.np_random.random(), "without one they go on")


class Reports(unittest.TestCase):
    def test_measures_that_are_not_known_are_left_out(self):
        report = read_report(
            {
                "scenario": "s", "seed": 2, "end_reason": "all done", "as_expected": False,
                "measures": {"kits_right": 1.0, "kit_mean_s": None},
                "expected": [
                    {"measure": "kits_right", "value": 1.0, "min": 2.0, "max": None, "kept": False}
                ],
            }
        )
        self.assertEqual(report.measures, {"kits_right": 1.0})
        self.assertEqual((report.verdicts[0].min, report.verdicts[0].kept), (2.0, False))


if __name__ == "__main__":
    unittest.main()
