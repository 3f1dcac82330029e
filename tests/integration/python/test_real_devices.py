"""Real robots by Simple Message, a PLC and cameras beside the cell, with a second daemon as the real side."""

import contextlib
import os
import pathlib
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from aprsim.real.base.device_socket import DeviceSocket
from aprsim.real.belts.modbus_wire import Frames, exception_of
from aprsim.real.building import Builder
from aprsim.real.cameras.vision_lines import read_line
from aprsim.real.settings import BeltSettings, CameraSettings, RobotSettings
from aprsim.real.simple_message.messages import HEADER, States, message
from aprsim.real.simple_message.requests import result_of
from real_support import HOST, TwoCells
from running_cell import PACKAGE, PATIENCE, await_that

WAIT_S = 60 * PATIENCE
WIRES = {"fanuc": "fanuc_karel", "motoman": "motoman_fs100"}


def ten(values):
    return struct.pack(">10f", *values, *[0.0] * (10 - len(values)))


class Controller:
    """A client of one port."""

    def __init__(self, address, cutter):
        self._device, self._cutter, self._waiting = DeviceSocket(*address, WAIT_S), cutter(), []

    def ask(self, request):
        """The answer to a request."""
        self._device.ask(request)
        return self.receive()

    def receive(self):
        self._device.ask(b"")
        while not self._waiting:
            self._waiting += self._cutter.add(self._device.receive())
        return self._waiting.pop(0)

    def close(self):
        self._device.close()


class Beside(TwoCells):
    """With one device at a time."""

    def build(self, settings):
        opened = self.enterContext(contextlib.ExitStack())
        device = Builder(self.cell, opened, self.told.append).build(settings)
        self.start(device.run)
        return device

    def client(self, address, cutter=States):
        controller = Controller(address, cutter)
        self.addCleanup(controller.close)
        return controller


class SimpleMessageTest(Beside):
    scene = "aprs_2025"

    def joints(self, cell, robot):
        return cell.snapshot(["robots"]).robot(robot).joints_rad

    def await_same(self, robot, within=1e-3):
        """The Motoman's wire counts whole pulses."""
        await_that(
            lambda: np.abs(self.joints(self.real, robot) - self.joints(self.cell, robot)).max() < within,
            (robot, self.told),
        )

    def gripper(self, cell, robot):
        return cell.snapshot(["robots"]).robot(robot).message.gripper.setting

    def settings(self, robot, source, **others):
        address = others.pop("address", None) or self.port(f"state.{robot}")
        return RobotSettings(
            name=robot, source=source, wire=WIRES[robot], address=address, patience_s=WAIT_S,
            motion=self.port(f"motion.{robot}"), gripper=self.port(f"gripper.{robot}"), **others,
        )  # fmt: skip

    def test_a_mirror_follows_through_all_that_its_device_does(self):
        for robot in WIRES:
            with self.subTest(robot):
                disturbed = self.disturbed(f"state.{robot}")
                device = self.build(self.settings(robot, "mirror", address=(HOST, disturbed.listens)))
                await_that(lambda: device.state() == "follows", self.told)
                start = self.joints(self.real, robot)
                self.real.robot(robot).move_by([0.02, 0.01, 0.05])
                self.assertGreater(np.abs(self.joints(self.real, robot) - start).max(), 0.01)
                self.await_same(robot)
                # A lost device stops the robot alone; lies do as well.
                disturbed.drop()
                self.await_told(f"{robot}: the real robot is lost")
                self.real.robot(robot).move_by([0, -0.02, 0])
                self.await_same(robot)
                self.told.clear()
                disturbed.change = lambda data: data[:20] + struct.pack(">f", 9.0) * 10 + data[60:]
                self.await_told("the real robot is lost")
                disturbed.change = None
                await_that(lambda: device.state() == "follows", self.told)
                disturbed.delay_s = 0.06  # several states at once
                self.real.robot(robot).move_by([0, 0.02, 0])
                self.await_same(robot)

    def test_a_gripper_is_mirrored(self):
        """The ports serve one client, so that the controller is gone before the mirror comes."""
        controller = self.client(self.port("gripper.motoman"))
        for address, value in ((10012, 1), (10010, 0), (10011, 1)):
            controller.ask(message(2005, struct.pack(">2i", address, value)))
        controller.close()
        controller = self.client(self.port("gripper.fanuc"), Words)
        controller.ask(struct.pack(">i", 1))
        controller.close()
        for robot in WIRES:
            self.assertEqual(self.gripper(self.cell, robot), 1)
            self.build(self.settings(robot, "mirror"))
            await_that(lambda: self.gripper(self.cell, robot) == 0, f"{robot} closed: {self.told}")

    def fanuc_point(self, sequence, joints):
        counted = np.array(joints)
        counted[2] -= counted[1]
        return message(11, struct.pack(">i", sequence) + ten(counted) + struct.pack(">2f", 0.1, 10))

    def test_a_proxy_passes_no_commands_unless_they_are_allowed(self):
        self.build(self.settings("fanuc", "proxy"))
        before = self.joints(self.real, "fanuc")
        states = self.client(self.listening("fanuc: states"))
        motion = self.client(self.listening("fanuc: controllers (motion)"))
        # Several controllers read states that the real robot sends to one alone.
        self.client(self.listening("fanuc: states")).receive()
        self.assertEqual(struct.unpack_from(">i", states.receive(), 4), (10,))
        answer = motion.ask(self.fanuc_point(1, before + [0.1, 0, 0, 0, 0, 0]))
        self.assertEqual(struct.unpack_from(">4i", answer), (56, 10, 3, 2))
        self.await_told("a command is refused")
        np.testing.assert_array_equal(self.joints(self.real, "fanuc"), before)

        self.build(self.settings("motoman", "proxy"))
        motion = self.client(self.listening("motoman: controllers (motion)"))
        gripper = self.client(self.listening("motoman: controllers (gripper)"))
        control = lambda command: message(2001, struct.pack(">3i", 0, 0, command) + bytes(40))  # noqa: E731
        self.assertEqual(result_of(motion.ask(control(200121))), (5, 5005))
        self.assertEqual(result_of(motion.ask(control(200101)))[0], 2)  # a question: the real one's own words
        answer = gripper.ask(message(2005, struct.pack(">2i", 10012, 1)))
        self.assertEqual(struct.unpack_from(">i", answer, HEADER.size), (1002,))
        self.assertEqual(self.real.snapshot(["robots"]).robot("motoman").message.motion.stream, 0)

    def test_a_proxy_commands_and_the_mirror_follows(self):
        self.build(self.settings("fanuc", "proxy", allow_commands=True))
        motion = self.client(self.listening("fanuc: controllers (motion)"))
        start = self.joints(self.real, "fanuc")
        goal = start + [0.1, 0.05, 0, 0, 0, 0]
        self.assertEqual(struct.unpack_from(">4i", motion.ask(self.fanuc_point(1, goal))), (56, 10, 3, 1))
        await_that(lambda: np.abs(self.joints(self.real, "fanuc") - goal).max() < 1e-3, "the real one")
        self.await_same("fanuc")
        gripper = self.client(self.listening("fanuc: controllers (gripper)"), Words)
        self.assertEqual(gripper.ask(struct.pack(">i", 1)), struct.pack(">i", 1))
        await_that(lambda: self.gripper(self.real, "fanuc") == 0, "the real gripper")
        await_that(lambda: self.gripper(self.cell, "fanuc") == 0, "ours")

    def test_a_shadow_does_the_same_until_it_is_moved(self):
        # Two daemons on a busy machine need not keep the same time.
        device = self.build(self.settings("motoman", "shadow", allow_commands=True, most_ms=10_000))
        await_that(lambda: device.state() == "does the same", self.told)
        motion = self.client(self.listening("motoman: controllers (motion)"))
        control = lambda command: message(2001, struct.pack(">3i", 0, 0, command) + bytes(40))  # noqa: E731
        self.assertEqual(result_of(motion.ask(control(200121))), (0, 0))
        await_that(
            lambda: self.cell.snapshot(["robots"]).robot("motoman").message.motion.stream != 0, "the copy's start"
        )
        start = self.joints(self.real, "motoman")
        turn = np.array([0.1, 0, 0.05, 0, 0, 0.1, 0.2])
        for number in range(21):
            share = number / 20
            smooth, slope = share * share * (3 - 2 * share), 6 * share * (1 - share) / 2
            head = struct.pack(">3if", 0, number, 7, 2 * share)
            point = message(14, head + ten(start + smooth * turn) + ten(slope * turn) + ten([]))
            while (result := result_of(motion.ask(point))) == (1, 0):
                pass  # BUSY: the same again
            self.assertEqual(result, (0, 0), number)
        for cell in (self.real, self.cell):
            await_that(lambda: np.abs(self.joints(cell, "motoman") - start - turn).max() < 1e-4, self.told)
        self.assertFalse([text for text in self.told if "refuses" in text], self.told)
        await_that(lambda: device.state() == "does the same", self.told)
        await_that(lambda: result_of(motion.ask(control(200122))) == (0, 0), "the real one's end")
        await_that(
            lambda: self.cell.snapshot(["robots"]).robot("motoman").message.motion.stream == 0, "the copy's end"
        )
        alarms = device.alarms()
        self.cell.robot("motoman").move_by([0, 0, 0.01])
        await_that(lambda: device.alarms() > alarms, self.told)
        self.await_told("mm apart")

    def test_a_shadow_of_the_fanuc_does_the_same_until_it_is_moved(self):
        device = self.build(self.settings("fanuc", "shadow", allow_commands=True, most_ms=10_000))
        await_that(lambda: device.state() == "does the same", self.told)
        motion = self.client(self.listening("fanuc: controllers (motion)"))
        gripper = self.client(self.listening("fanuc: controllers (gripper)"), Words)
        start = self.joints(self.real, "fanuc")
        for number, turn in enumerate(([-0.2, 0, 0], [-0.2, 0.1, -0.1], [-0.1, 0.1, 0], [0, 0, 0]), 1):
            goal = start + [*turn, 0.1 * (number % 2), 0, 0]
            self.assertEqual(struct.unpack_from(">4i", motion.ask(self.fanuc_point(number, goal))), (56, 10, 3, 1))
            for cell in (self.real, self.cell):
                await_that(lambda: np.abs(self.joints(cell, "fanuc") - goal).max() < 1e-3, self.told)
        for word, setting in ((1, 0), (0, 1)):
            gripper.ask(struct.pack(">i", word))
            for cell in (self.real, self.cell):
                await_that(lambda: self.gripper(cell, "fanuc") == setting, (word, self.told))
        await_that(lambda: device.state() == "does the same", self.told)
        self.assertFalse([text for text in self.told if "refuses" in text], self.told)
        motion.close()
        alarms = device.alarms()
        await_that(lambda: self.cell.snapshot(["robots"]).robot("fanuc").message.motion.stream == 0, "the copy's end")
        self.cell.robot("fanuc").move_by([0, 0, 0.01])
        await_that(lambda: device.alarms() > alarms, self.told)
        self.await_told("mm apart")


class Words:
    """Cuts words of four bytes."""

    def __init__(self):
        self._bytes = b""

    def add(self, data):
        self._bytes += data
        whole = len(self._bytes) // 4 * 4
        out = [self._bytes[at : at + 4] for at in range(0, whole, 4)]
        self._bytes = self._bytes[whole:]
        return out


class BeltTest(Beside):
    def write(self, client, register, value):
        return client.ask(struct.pack(">HHHBBHH", 1, 0, 6, 1, 6, register, value))

    def settings(self, source, **others):
        return BeltSettings(source=source, address=self.port("modbus"), patience_s=WAIT_S, **others)

    def belt(self, cell):
        return cell.snapshot(["conveyor"]).message.conveyor

    def test_a_shadow_gets_the_writes_and_is_compared(self):
        device = self.build(self.settings("shadow", allow_commands=True, most_ms=10_000, most_mm=20))
        controller = self.client(self.listening("conveyor: controllers"), Frames)
        for register, value in ((0x8002, 10_000), (0x8001, 1), (0x8000, 1)):
            self.assertEqual(exception_of(self.write(controller, register, value)), 0)
        for cell in (self.real, self.cell):
            await_that(lambda: abs(self.belt(cell).speed_m_s - 0.1) < 1e-6, "both run")
        self.write(controller, 0x8000, 0)
        for cell in (self.real, self.cell):
            await_that(lambda: self.belt(cell).speed_m_s == 0, "both stand")
        await_that(lambda: device.state() == "does the same", self.told)
        alarms = device.alarms()
        self.cell.set_conveyor(True, forward=True, speed_m_s=0.1)  # the simulated one alone
        await_that(lambda: device.alarms() > alarms, self.told)

    def test_without_permission_only_reads_pass(self):
        device = self.build(self.settings("proxy"))
        controller = self.client(self.listening("conveyor: controllers"), Frames)
        self.assertEqual(exception_of(self.write(controller, 0x8000, 1)), 1)
        self.await_told("a command is refused")
        answer = controller.ask(struct.pack(">HHHBBHH", 9, 0, 6, 1, 3, 0x8000, 3))
        self.assertEqual(struct.unpack(">HHHBBB3H", answer)[:6], (9, 0, 9, 1, 3, 6))
        self.assertFalse(self.belt(self.real).run)
        self.real.set_conveyor(True, forward=False, speed_m_s=0.05)
        await_that(lambda: self.belt(self.cell).run and device.state() == "follows", "the mirror of the proxy")


    def test_a_disturbed_plc_stops_the_belt_alone(self):
        disturbed = self.disturbed("modbus")
        settings = BeltSettings(source="mirror", address=(HOST, disturbed.listens), patience_s=2 * PATIENCE)
        device = self.build(settings)
        self.real.set_conveyor(True, forward=True, speed_m_s=0.1)
        await_that(lambda: self.belt(self.cell).run, self.told)
        disturbed.drop()
        self.await_told("the real PLC is lost")
        await_that(lambda: self.belt(self.cell).run, "it is back")
        disturbed.stalls.set()
        self.await_told("no answer within")
        await_that(lambda: not self.belt(self.cell).run, "it stands")
        disturbed.stalls.clear()
        await_that(lambda: self.belt(self.cell).run, "it is back")
        for lie in (b"\xff" * 8, bytes(12)):
            self.told.clear()
            disturbed.change = lambda data, lie=lie: lie
            self.await_told("the real PLC is lost")
            disturbed.change = None
            await_that(lambda: device.state() == "follows", self.told)
            await_that(lambda: self.belt(self.cell).run, "it is back")


class CameraTest(Beside):
    def pose(self, cell, body):
        return cell.snapshot(["bodies"]).body(body).pose

    def settings(self, source, address=None, **others):
        address = address or self.port("vision.fanuc")
        return CameraSettings(name="fanuc", source=source, address=address, patience_s=WAIT_S, **others)

    def seen_gear(self):
        """A gear that the cameras see from above, outside of a tray's slots or not."""
        found = self.cell.snapshot(["robots"]).robot("fanuc").message.vision.detections
        names = [one.body for one in found]
        kinds = {name: body.type for name, body in self.cell.snapshot(["bodies"]).bodies.items()}
        return next(name for name in names if "gear" in kinds[name])

    def test_a_moved_gear_is_moved(self):
        await_that(lambda: self.cell.snapshot(["robots"]).robot("fanuc").message.vision.number > 0, "a frame")
        gear = self.seen_gear()
        disturbed = self.disturbed("vision.fanuc")
        device = self.build(self.settings("mirror", (HOST, disturbed.listens)))
        await_that(lambda: device.state() == "follows", self.told)
        before = self.cell.snapshot(["bodies"]).bodies
        pose = self.pose(self.real, gear)
        pose[:3, 3] += [0.03, 0.12, 0.02]
        self.real.move_body(gear, pose)
        await_that(
            lambda: np.linalg.norm((self.pose(self.real, gear) - self.pose(self.cell, gear))[:2, 3]) < 4e-3,
            self.told,
        )
        self.await_told("is moved")
        # Nothing else has moved.
        for name, body in self.cell.snapshot(["bodies"]).bodies.items():
            if body.type != before[gear].type:
                np.testing.assert_allclose(body.position_m[:2], before[name].position_m[:2], atol=2e-3, err_msg=name)
        # Lies move nothing, and are reported.
        self.told.clear()
        disturbed.change = lambda data: data.replace(b",P,", b",nan,Q,")
        self.await_told("the real camera is lost")
        disturbed.change = None
        await_that(lambda: device.state() == "follows", self.told)
        disturbed.drop()
        await_that(lambda: sum("is lost" in text for text in self.told) >= 2, self.told)

    def test_a_gear_that_leans_in_its_slot_is_stood_upright(self):
        """As after a grip that failed here alone."""
        gear = "part_medium_gear_1"
        pose = self.pose(self.real, gear)
        pose[:3, 3] += [0.012, 0, 0.01]
        self.cell.move_body(gear, pose)
        await_that(lambda: abs(self.pose(self.cell, gear)[2, 2]) < 0.98, "it leans")
        self.build(self.settings("mirror"))
        await_that(
            lambda: np.abs((self.pose(self.real, gear) - self.pose(self.cell, gear))[:2, 3]).max() < 4e-3
            and self.pose(self.cell, gear)[2, 2] > 0.99,
            self.told,
        )
        self.await_told(f"{gear} is moved")

    def test_a_proxy_passes_lines_and_pictures(self):
        camera = next(key for key in self.real.endpoints.ports if key.startswith("camera."))
        self.build(self.settings("proxy", pictures=self.port(camera)))
        reader = DeviceSocket(*self.listening("camera of fanuc: controllers"), WAIT_S)
        self.addCleanup(reader.close)
        reader.ask(b"")
        data = b""
        while data.count(b"\n") < 2:
            data += reader.receive()
        line = data.split(b"\n")[1] if not data.startswith(b"sku") else data.split(b"\n")[0]
        self.assertTrue(any("gear" in one.type_name for one in read_line(line.decode())))
        pictures = DeviceSocket(*self.listening("camera of fanuc: pictures"), WAIT_S)
        self.addCleanup(pictures.close)
        pictures.ask(b"GET /jpg/image.jpg HTTP/1.1\r\nHost: x\r\n\r\n")
        data = b""
        while b"\xff\xd8" not in data:
            data += pictures.receive()
        self.assertTrue(data.startswith(b"HTTP/1.1 200"), data[:80])
        other = DeviceSocket(*self.listening("camera of fanuc: pictures"), WAIT_S)
        self.addCleanup(other.close)
        other.ask(b"POST /jpg/image.jpg HTTP/1.1\r\nHost: x\r\n\r\n")
        self.assertIn(b"405", other.receive())


class ProgramTest(TwoCells):
    def run_program(self, text, *words):
        folder = self.enterContext(tempfile.TemporaryDirectory())
        path = pathlib.Path(folder) / "lab.yaml"
        path.write_text(text, encoding="utf-8")
        command = [sys.executable, "-m", "aprsim.real", "run", str(path), *words]
        running = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env=os.environ | {"PYTHONPATH": str(PACKAGE)},
        )  # fmt: skip
        self.addCleanup(running.stderr.close)
        self.addCleanup(running.stdout.close)
        self.addCleanup(running.kill)
        return running

    def test_a_file_runs_until_sigterm(self):
        """`python3 -m aprsim.real run FILE`: all devices in one process, one of which is not there."""
        with socket.create_server((HOST, 0)) as silent:
            text = f"""
patience_s: {WAIT_S if WAIT_S <= 60 else 60}
robots:
  fanuc: {{source: mirror, address: "{HOST}:{self.port('crcl.fanuc')[1]}"}}
  motoman: {{source: proxy, address: "{HOST}:{self.port('crcl.motoman')[1]}"}}
conveyor: {{source: mirror, address: "{HOST}:{self.port('modbus')[1]}"}}
cameras:
  fanuc: {{source: mirror, address: "{HOST}:{silent.getsockname()[1]}", patience_s: 0.1}}
"""
            running = self.run_program(text, "--ports-file", str(self.ours.ports_file))
            wanted = "fanuc follows, motoman follows, camera of fanuc does not follow, conveyor follows"
            for line in running.stdout:
                if "status:" in line and wanted in line:
                    break
            self.real.robot("fanuc").move_by([0, 0, -0.02])
            joints = lambda cell: cell.snapshot(["robots"]).robot("fanuc").joints_rad  # noqa: E731
            await_that(lambda: np.abs(joints(self.real) - joints(self.cell)).max() < 1e-6, "it follows")
            running.send_signal(signal.SIGTERM)
            _, errors = running.communicate(timeout=WAIT_S)
            self.assertEqual((running.returncode, errors), (0, ""))
        await_that(
            lambda: all(one.message.motion.stream == 0 for one in self.cell.snapshot(["robots"]).robots.values()),
            "the robots are free",
        )

    def test_a_wrong_file_is_told(self):
        for text, told in (
            ("robots:\n  fanuc: {sorce: mirror}", "lab.yaml:2: robots.fanuc.sorce: no such key; did you mean"),
            (f'robots:\n  arm: {{source: mirror, address: "{HOST}:1"}}', "no robot 'arm'"),
            (f'cameras:\n  arm: {{source: mirror, address: "{HOST}:1"}}', "no robot 'arm'"),
        ):
            running = self.run_program(text, "--ports-file", str(self.ours.ports_file))
            _, errors = running.communicate(timeout=WAIT_S)
            self.assertEqual((running.returncode, told in errors), (2, True), errors)


if __name__ == "__main__":
    unittest.main()
