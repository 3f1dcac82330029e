"""Robots of the blocking cell."""

import contextlib
import io
import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest
import grpc
from unittest import mock

import grpc
import numpy as np
from aprsim import AprsimError, Cell, RobotError, crcl
from aprsim.binaries import find_binary
from aprsim.crcl.v1 import commands_pb2, robot_service_pb2, robot_service_pb2_grpc, status_pb2
from running_cell import PATIENCE, ROOT, WithCell


class RobotTest(WithCell):
    def test_connecting_commands_nothing(self):
        mover = self.cell.robot("fanuc")
        target = mover.tool() + 0
        target[2, 3] -= 0.1
        mover.move_to(target, wait=False)
        self.assertTrue(self.cell.step(100).robot("fanuc").moving)
        before = self.commands()
        with Cell.connect(self.daemon.ports_file) as other:
            viewer = other.robot("fanuc")
            np.testing.assert_allclose(
                viewer.tool(), self.cell.snapshot().robot("fanuc").tool_in_world, atol=1e-9
            )
            np.testing.assert_allclose(
                viewer.tool("robot"), self.cell.snapshot().robot("fanuc").tool_in_reference, atol=1e-9
            )
            self.assertEqual(viewer.status().state, "CRCL_Working")
        self.assertEqual(self.commands(), before)
        mover.wait()
        np.testing.assert_allclose(mover.tool(), target, atol=1e-5)

    def test_the_first_command_takes_the_robot(self):
        mover = self.cell.robot("fanuc")
        mover.move_by([0, 0, -0.1], wait=False)
        self.cell.step(100)
        with Cell.connect(self.daemon.ports_file) as other:
            taker = other.robot("fanuc")
            taker.stop()
            self.assertFalse(self.cell.step(1).robot("fanuc").moving)
            before = self.commands()
            taker.move_by([0, 0, 0.02])
            self.assertEqual(self.commands()[len(before):][0], "initialize")
            first = self.commands()
            taker.move_by([0, 0, 0.01])
            taker.take()
            self.assertNotIn("initialize", self.commands()[len(first):])
        self.cell.reset()
        before = self.commands()
        mover.take()
        self.assertIn("initialize", self.commands()[len(before):], "after a reset it takes it again")

    def commands(self):
        """The commands that robots have begun so far."""
        kinds = ["command_begun"]
        return [event.text for event in self.cell.events(0, kinds=kinds, past_only=True, allow_gap=True)]

    def test_moves_where_it_is_told(self):
        fanuc = self.cell.robot("fanuc")
        self.assertIs(self.cell.robot("fanuc"), fanuc)
        before = fanuc.tool()
        np.testing.assert_allclose(
            before, self.cell.snapshot().robot("fanuc").tool_in_world, atol=1e-9
        )
        fanuc.move_by([0.02, 0, -0.05])
        after = fanuc.tool()
        np.testing.assert_allclose(after[:3, 3] - before[:3, 3], [0.02, 0, -0.05], atol=1e-5)
        np.testing.assert_allclose(after[:3, :3], before[:3, :3], atol=1e-6)
        fanuc.move_to([0.3, -1.0, 1.2], yaw=0.3, straight=True)
        seen = self.cell.snapshot().robot("fanuc")
        np.testing.assert_allclose(seen.tool_in_world[:3, 3], [0.3, -1.0, 1.2], atol=1e-5)
        np.testing.assert_allclose(seen.tool_in_world[:3, 2], [0, 0, -1], atol=1e-6)
        fanuc.move_to(before)
        np.testing.assert_allclose(fanuc.tool(), before, atol=1e-5)
        fanuc.move_to(seen.tool_in_reference, frame="robot")
        np.testing.assert_allclose(fanuc.tool("robot"), seen.tool_in_reference, atol=1e-5)

    def test_robots_by_messages_over_grpc(self):
        self.cell.resume()
        port = json.loads(pathlib.Path(self.daemon.ports_file).read_text())["grpc"]
        with grpc.insecure_channel(f"127.0.0.1:{port}") as channel:
            robots = robot_service_pb2_grpc.RobotServiceStub(channel)
            options = robot_service_pb2.SessionOptions(robot="motoman")

            def execute(command):
                request = robot_service_pb2.ExecuteRequest(
                    options=options, command=commands_pb2.CommandInstance(command=command)
                )
                answer = robots.Execute(request, timeout=60 * PATIENCE)
                self.assertFalse(answer.replaced)
                return answer.status.command_status

            init = execute(commands_pb2.Command(command_id=1, init_canon={}))
            self.assertEqual(init.command_state, status_pb2.COMMAND_STATE_DONE)
            dwell = commands_pb2.Command(command_id=2, dwell={"dwell_time_s": 0.1})
            self.assertEqual(execute(dwell).command_id, 2)
            refused = execute(commands_pb2.Command(command_id=3, dwell={"dwell_time_s": -1}))
            self.assertEqual(refused.command_state, status_pb2.COMMAND_STATE_ERROR)
            self.assertTrue(refused.state_description)

    def test_joints_and_gripper(self):
        fanuc = self.cell.robot("fanuc")
        target = [0.1, 0.05, -0.1, 0.2, -1.4, 0.3]
        fanuc.move_joints(target, speed_rad_s=1.5)
        np.testing.assert_allclose(
            self.cell.snapshot().robot("fanuc").joints_rad, target, atol=1e-5
        )
        fanuc.close_gripper()
        fanuc.dwell(0.5)
        closed = self.cell.snapshot().robot("fanuc").separation_m
        fanuc.open_gripper()
        fanuc.dwell(0.5)
        self.assertGreater(self.cell.snapshot().robot("fanuc").separation_m, closed + 0.005)
        with self.assertRaisesRegex(AprsimError, "6 finite numbers"):
            fanuc.move_joints([1, 2])

    def test_the_same_commands_give_the_same_bits(self):
        def work():
            self.cell.reset()
            robot = self.cell.robot("motoman")
            robot.move_by([0, 0.05, -0.05])
            robot.close_gripper()
            robot.move_by([0, -0.05, 0.05])
            snapshot = self.cell.snapshot()
            return snapshot.step, snapshot.state_hash

        self.assertEqual(work(), work())

    def test_does_other_things_while_it_moves(self):
        fanuc = self.cell.robot("fanuc")
        fanuc.move_to(fanuc.tool()[:3, 3] + [0, 0, -0.1], wait=False)
        self.assertFalse(fanuc.is_done())
        self.assertTrue(self.cell.step(100).robot("fanuc").moving)
        fanuc.wait()
        self.assertTrue(fanuc.is_done())
        fanuc.move_to(fanuc.tool()[:3, 3] + [0, 0, 0.1], wait=False)
        self.cell.step(100)
        fanuc.stop()
        self.assertFalse(self.cell.step(1).robot("fanuc").moving)

    def test_tells_what_the_robot_refuses(self):
        fanuc = self.cell.robot("fanuc")
        with self.assertRaisesRegex(RobotError, "fanuc: MoveTo: .*out of reach"):
            fanuc.move_to([3, 0, 1])
        with self.assertRaisesRegex(RobotError, "In error until InitCanon"):
            fanuc.move_by([0, 0, 0.01])
        fanuc.initialise()
        fanuc.move_by([0, 0, 0.01])
        fanuc.end()
        fanuc.move_by([0, 0, -0.01])  # the robot stays initialised, as on NIST's servers
        with self.assertRaisesRegex(AprsimError, "no robot 'kuka'; there is fanuc, motoman"):
            self.cell.robot("kuka")

    def test_its_documents_keep_to_the_schema(self):
        commands = [
            crcl.initialise(), crcl.end(), crcl.stop("Fast"), crcl.move_to(np.eye(4), straight=True),
            crcl.move_joints({1: 10.0, 2: -1e-7}, 30), crcl.set_gripper(0.5), crcl.dwell(1.5),
            crcl.set_speed(0.25), crcl.set_turn_speed(1), *crcl.Session.opening(),
        ]
        with tempfile.TemporaryDirectory() as folder:
            for number, command in enumerate(commands, 1):
                path = pathlib.Path(folder) / f"{command.kind}.xml"
                path.write_bytes(crcl.encode(command, number))
                done = subprocess.run(
                    [find_binary("aprsim"), "crcl", "validate", str(path)],
                    capture_output=True, text=True, timeout=60 * PATIENCE,
                )
                self.assertEqual(done.returncode, 0, f"{path.read_text()}: {done.stderr}")

    def test_the_five_lines_of_the_readme(self):
        text = (ROOT / "README.md").read_text(encoding="utf-8")
        block = re.search(r"^```python\n(from aprsim import Cell\n.*?)^```\n", text, re.M | re.S)
        self.assertIsNotNone(block)
        code = block[1]
        self.assertLessEqual(len([line for line in code.splitlines() if line]), 5)
        printed = io.StringIO()
        ports = {"APRSIM_PORTS_FILE": str(self.daemon.ports_file)}
        with mock.patch.dict(os.environ, ports), contextlib.redirect_stdout(printed):
            names = {}
            exec(compile(code, "README.md", "exec"), names)
            names["cell"].close()
        height = float(printed.getvalue().split()[-1].strip("[]"))
        after = self.cell.snapshot().robot("fanuc").tool_in_world[2, 3]
        self.assertAlmostEqual(height, after, places=3)
        self.cell.reset()
        self.assertAlmostEqual(
            self.cell.snapshot().robot("fanuc").tool_in_world[2, 3] - after, 0.05, places=4
        )
        for document in ("clients/python/README.md", "docs/python.md"):
            self.assertIn(block[0], (ROOT / document).read_text(encoding="utf-8"), document)


if __name__ == "__main__":
    unittest.main()
