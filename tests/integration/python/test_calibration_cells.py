"""Parameters of second cells that calibrate does not know: one driven by Simple Message, one whose camera sees
trays that slip on the belt."""

import contextlib
import json
import pathlib
import socket
import struct
import tempfile
import unittest

import numpy as np
from modbus_requests import ask
from running_cell import PATIENCE, await_that

from aprsim import Cell, Daemon
from aprsim.calibration.calibrating import calibrate
from aprsim.real.base.device_socket import DeviceSocket
from aprsim.real.simple_message.messages import States, message
from aprsim.real.simple_message.requests import result_of


class CarriedTest(unittest.TestCase):
    """A second cell, whose camera sees trays that slip on the belt."""

    HIDDEN = """base: aprs
robots:
- name: motoman
  vision:
    latency_s: 0.25
    calibration:
    - {at_m: [0.3, -0.3], reported_m: [0.3, -0.3]}
    - {at_m: [0.8, -0.3], reported_m: [0.8, -0.3]}
    - {at_m: [0.8, 0.3], reported_m: [0.8, 0.3]}
    - {at_m: [0.3, 0.3], reported_m: [0.3, 0.3]}
physics:
  friction: {tray_belt: 0.03}
"""
    STEPS = 4

    def test_latency_and_friction_are_recovered(self):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        hidden, journal = folder / "hidden.yaml", folder / "run.journal"
        hidden.write_text(self.HIDDEN, encoding="utf-8")
        options = ("--journal", str(journal), "--no-web")
        with Daemon(*options, scene=str(hidden), speed="stepped", start_s=60 * PATIENCE) as daemon:
            ports = json.loads(pathlib.Path(daemon.ports_file).read_text(encoding="utf-8"))
            with (
                Cell.connect(daemon.ports_file) as cell,
                socket.create_connection(("127.0.0.1", ports["vision.motoman"]), 60 * PATIENCE) as camera,
                socket.create_connection(("127.0.0.1", ports["modbus"]), 60 * PATIENCE) as modbus,
                camera.makefile("rb") as lines,
            ):
                self.work(cell, lines, modbus)
        estimates = calibrate([journal], "aprs")
        found = {one.name: one for one in estimates.estimates}
        for name, value in (("robots.motoman.vision.latency_s", 0.25), ("physics.friction.tray_belt", 0.03)):
            self.assertTrue(found[name].is_told, f"{name}: {found[name].why_not}")
            self.assertLess(abs(found[name].value - value), 0.05 * value, found[name])
        self.assertIn("tray_belt: 0.0", estimates.overlay())

    def work(self, cell, lines, modbus):
        """The belt forward and back, while each frame is read before time goes on. Frames come again and again."""
        line = b""
        frame = cell.snapshot(["robots"]).robot("motoman").message.vision.number
        ask(modbus, struct.pack(">BHH", 6, 0x8002, 15000))
        for forward, run, steps in ((1, 0, 500), (1, 1, 800), (1, 0, 900), (0, 1, 800), (0, 0, 900)):
            ask(modbus, struct.pack(">BHH", 6, 0x8001, forward))
            ask(modbus, struct.pack(">BHH", 6, 0x8000, run))
            for _ in range(steps // self.STEPS):
                cell.step(self.STEPS)
                ask(modbus, struct.pack(">BHH", 4, 0x8000, 8))
                now = cell.snapshot(["robots"]).robot("motoman").message.vision.number
                if now != frame:
                    frame, last = now, line
                    while (line := lines.readline()) == last:
                        pass


class JointsTest(unittest.TestCase):
    """A second cell, driven by Simple Message."""

    HIDDEN = """base: aprs_2025
robots:
- name: fanuc
  servers: {simple_message: {controller: fanuc_karel, joint_speed: 0.13, cnt: 50}}
"""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        hidden = cls.folder / "hidden.yaml"
        hidden.write_text(cls.HIDDEN, encoding="utf-8")
        cls.journal = cls.folder / "run.journal"
        options = ("--journal", str(cls.journal), "--no-web")
        with Daemon(*options, scene=str(hidden), start_s=60 * PATIENCE) as daemon:
            ports = json.loads(pathlib.Path(daemon.ports_file).read_text(encoding="utf-8"))
            with Cell.connect(daemon.ports_file) as cell, contextlib.ExitStack() as opened:
                connect = lambda key: opened.enter_context(DeviceSocket("127.0.0.1", ports[key], 60 * PATIENCE))  # noqa: E731
                for robot in ("fanuc", "motoman"):
                    connect(f"state.{robot}").ask(b"")
                cls.fanuc(cell, connect("motion.fanuc"))
                cls.motoman(cell, connect("motion.motoman"))

    @staticmethod
    def await_rest(cell, robot, joints):
        """The robot at these joints, and half a second of simulated time."""
        here = lambda: cell.snapshot(["robots"]).robot(robot).joints_rad  # noqa: E731
        await_that(lambda: np.abs(here() - joints).max() < 1e-4, robot)
        until_s = cell.snapshot().sim_time_s + 0.5
        await_that(lambda: cell.snapshot().sim_time_s > until_s, "time")

    @classmethod
    def fanuc(cls, cell, motion):
        """Moves of single joints, from rest to rest."""
        start = cell.snapshot(["robots"]).robot("fanuc").joints_rad
        for number in range(1, 11):
            goal = start.copy()
            goal[number % 3] -= 0.5 if number % 3 == 0 else 0.3
            for target in (goal, start):
                counted = np.concatenate([target, np.zeros(4)])
                counted[2] -= counted[1]
                motion.ask(message(11, struct.pack(">i10f2f", number, *counted, 0.1, 10)))
                motion.exactly(60)
                cls.await_rest(cell, "fanuc", target)

    @classmethod
    def motoman(cls, cell, motion):
        """Streamed trajectories."""
        answer = States()

        def ask(request):
            motion.ask(request)
            while not (found := answer.add(motion.receive())):
                pass
            return result_of(found[0])

        assert ask(message(2001, struct.pack(">3i", 0, 0, 200121) + bytes(40))) == (0, 0)
        for way in (1, -1, 1, -1):
            start = cell.snapshot(["robots"]).robot("motoman").joints_rad
            turn = way * np.array([0.2, 0.1, 0.05, 0, 0, 0.1, 0.2])
            for number in range(21):
                share = number / 20
                smooth, slope = share * share * (3 - 2 * share), 6 * share * (1 - share) / 2
                head = struct.pack(">3if", 0, number, 7, 2 * share)
                values = np.concatenate([start + smooth * turn, np.zeros(3), slope * turn, np.zeros(13)])
                while (result := ask(message(14, head + struct.pack(">30f", *values)))) == (1, 0):
                    pass  # BUSY: the same again
                assert result == (0, 0), (number, result)
            cls.await_rest(cell, "motoman", start + turn)

    def test_hidden_parameters_are_recovered(self):
        found = {one.name: one for one in calibrate([self.journal], "aprs_2025").estimates}
        share = found["robots.fanuc.servers.simple_message.joint_speed"]
        self.assertLess(abs(share.value - 0.13), 0.05 * 0.13, share)
        self.assertIn("joint_speed: 0.1", calibrate([self.journal], "aprs_2025").overlay())
        pace = found["robots.motoman.trajectory_pace"]
        self.assertLess(abs(pace.value - 1), 1e-3, pace)
        for robot in ("fanuc", "motoman"):
            latency = found[f"robots.{robot}.motion_latency_s"]
            self.assertTrue(latency.is_told, latency.why_not)
            self.assertLess(abs(latency.value), 0.02)
            self.assertTrue(found[f"robots.{robot}.state_period_s"].is_told)
        for joint in (1, 2, 3):
            self.assertTrue(found[f"robots.fanuc.joint_{joint}_accel_rad_s2"].is_told)


if __name__ == "__main__":
    unittest.main()
