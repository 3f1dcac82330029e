"""Replays of sessions of the drivers of the laboratory's ROS 2 controllers (recordings/ros2/, made by record_ros2.py).
The recorded input is sent byte for byte at the same simulated times. Every reply must have the recorded bytes; a point
that is answered BUSY is sent again, as the drivers do. The robots' status must go through the recorded states, and the
robots must end at the recorded joints."""

import os
import pathlib
import socket
import struct
import subprocess
import threading
import time
import unittest

from ros2_messages import (
    FEEDBACK_LENGTH,
    JOINTS_LENGTH,
    STATUS_LENGTH,
    is_busy,
    joints_of,
    split_messages,
    status_of,
    unpacked,
)
from test_recordings import PATIENCE_MS, WALL_S, Stepper, Wire, running_cell

RECORDINGS = pathlib.Path(__file__).resolve().parent / "recordings" / "ros2"
# A driver takes a goal for reached from here on, so that the last recorded state may still move.
JOINT_RAD = 0.011
SETTLING_MS = 1000
# Each robot's state port: length of its first message, and of these between two statuses.
PATTERN = {"fanuc": (JOINTS_LENGTH, 11), "motoman": (FEEDBACK_LENGTH, 1)}
QUIET_S = 0.2


class Recording:
    """A file of recordings/ros2: options of the daemon, events, and what the end was."""

    def __init__(self, path):
        self.options, self.events, self.busy, self.joints = [], [], {}, {}
        for line in path.read_text(encoding="ascii").splitlines():
            verb, _, rest = line.partition(" ")
            if verb == "option":
                self.options.append(rest)
            elif verb == "busy":
                robot, count = rest.split()
                self.busy[robot] = int(count)
            elif verb == "joints":
                robot, *joints = rest.split()
                self.joints[robot] = [float(joint) for joint in joints]
            elif verb != "#":
                connection, gap_ms, *text = rest.split(" ", 2)
                self.events.append((verb, int(connection), int(gap_ms), text[0] if text else ""))


class StateReader(threading.Thread):
    """Reads a state port as it comes: the latest status and joints, and whether the messages follow the pattern."""

    def __init__(self, port, robot):
        super().__init__(daemon=True)
        self.socket = socket.create_connection(("127.0.0.1", port), WALL_S)
        self.socket.settimeout(None)
        self.length, self.between = PATTERN[robot]
        self.changed = threading.Condition()
        self.status = self.joints = None
        self.count, self.fault = 0, ""
        self.has_gaps = False  # by an injected fault
        self.start()

    def run(self):
        data, since = b"", None
        while True:
            try:
                more = self.socket.recv(1 << 16)
            except OSError:
                return
            if not more:
                return
            messages, data = split_messages(data + more, True)
            with self.changed:
                for message in messages:
                    since = self._take(message, since)
                self.changed.notify_all()

    def _take(self, message, since):
        """The number of messages since the latest status, None before the first one."""
        (length,) = struct.unpack(">i", message[:4])
        self.count += 1
        if length == STATUS_LENGTH:
            if since not in (None, self.between) and not self.has_gaps:
                self.fault = f"{since} messages between two statuses"
            self.status = status_of(message)
            return 0
        if length != self.length:
            self.fault = f"a message of {length} bytes"
        self.joints = joints_of(message)
        return None if since is None else since + 1

    def wait_for(self, condition, seconds):
        with self.changed:
            return self.changed.wait_for(condition, seconds)


class Ros2Test(unittest.TestCase):
    def replay(self, path):
        self.recording = Recording(path)
        self.daemon = running_cell.Daemon(
            running_cell.BINARIES, *self.words(self.recording.options), "--no-web", "--speed", "stepped"
        )
        self.addCleanup(self.daemon.close)
        self.stepper = Stepper(self.daemon.ports["grpc"])
        self.addCleanup(self.stepper.close)
        self.wires, self.readers, self.robots = {}, {}, {}
        self.sent, self.busy = {}, {}
        for verb, connection, gap_ms, text in self.recording.events:
            try:
                if gap_ms > 0:
                    self.stepper.step(gap_ms)
                getattr(self, f"do_{verb}")(connection, text)
            except (AssertionError, ConnectionError, OSError) as fault:
                self.fail(f"{fault} at: {verb} {connection} {text[:300]}\n{self.daemon.log_text()[-1500:]}")
        self.check_end()

    @staticmethod
    def words(options):
        return [word for option in options for word in option.split()]

    def do_open(self, connection, target):
        kind, robot = target.split(".")
        self.robots[connection] = robot
        if kind == "state":
            self.readers[connection] = StateReader(self.daemon.ports[target], robot)
            self.readers[connection].has_gaps = ("quiet", connection) in {event[:2] for event in self.recording.events}
            self.addCleanup(self.readers[connection].socket.close)
        else:
            self.wires[connection] = wire = Wire(self.daemon.ports[target])
            wire.framed = target != "gripper.fanuc"
            self.addCleanup(wire.socket.close)

    def do_send(self, connection, text):
        self.sent[connection] = unpacked(text)
        try:
            self.wires[connection].socket.sendall(self.sent[connection])
        except OSError:
            pass  # an injected fault has dropped the connection; a recorded reply will be missed

    def do_reply(self, connection, text):
        wire, wanted = self.wires[connection], unpacked(text)
        deadline, waited = time.monotonic() + WALL_S, 0
        wire.take(0.1)
        while True:
            messages, _ = split_messages(wire.read, wire.framed)
            if messages and not (is_busy(messages[0]) and not is_busy(wanted)):
                break
            self.assertLess(time.monotonic(), deadline)
            self.assertLess(waited, PATIENCE_MS)
            self.stepper.step(2)
            waited += 2
            if messages:
                wire.read = wire.read[len(messages[0]) :]
                robot = self.robots[connection]
                self.busy[robot] = self.busy.get(robot, 0) + 1
                wire.socket.sendall(self.sent[connection])
            wire.take(0.01)
        self.assertEqual(messages[0].hex(), wanted.hex())
        wire.read = wire.read[len(messages[0]) :]

    def do_status(self, connection, text):
        reader, wanted = self.readers[connection], tuple(map(int, text.split()))
        waited = 0
        # A status comes each 264 ms of the wall's time at least.
        while not reader.wait_for(lambda: reader.status == wanted, 0.6 * running_cell.PATIENCE):
            self.assertLess(waited, 1000, f"{reader.status} in place of {wanted}")
            self.stepper.step(20)
            waited += 20

    def do_quiet(self, connection, _):
        reader = self.readers[connection]
        count = reader.count
        self.assertFalse(reader.wait_for(lambda: reader.count > count, QUIET_S))

    def do_cell(self, _, text):
        """A command of `aprsim`. One that waits for the robot needs steps."""
        waits = text.startswith("crcl ")
        command = subprocess.Popen(
            [os.path.join(running_cell.BINARIES, "aprsim"), "--ports-file", self.daemon.ports_file, *text.split()],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        with command:
            while waits and command.poll() is None:
                self.stepper.step(1)
            self.assertEqual(command.wait(WALL_S), 0, command.stderr.read())

    def do_close(self, connection, _):
        end = self.wires.get(connection) or self.readers[connection]
        try:
            end.socket.shutdown(socket.SHUT_WR)
        except OSError:
            pass  # the daemon has closed it

    def do_gone(self, connection, _):
        """The daemon has closed the connection."""
        if connection in self.readers:
            self.readers[connection].join(WALL_S)
            self.assertFalse(self.readers[connection].is_alive())
            return
        wire = self.wires[connection].socket
        wire.settimeout(WALL_S)
        try:
            self.assertEqual(wire.recv(1), b"")
        except ConnectionResetError:
            pass

    def check_end(self):
        for robot, count in self.recording.busy.items():
            self.assertGreater(count, 0)
            self.assertGreater(self.busy.get(robot, 0), 0, f"{robot} has never been busy")
        for connection, reader in self.readers.items():
            self.assertEqual(reader.fault, "", self.robots[connection])
            self.assertGreater(reader.count, 1, self.robots[connection])
        self.stepper.step(SETTLING_MS)
        state = running_cell.snapshot(self.daemon)
        for robot in state["robots"]:
            got = [joint.get("position_rad", 0.0) for joint in robot["joints"]]
            if robot["name"] == "fanuc":
                got[2] -= got[1]  # its wire counts the third joint against the horizontal
            for angle, wanted in zip(got, self.recording.joints[robot["name"]]):
                self.assertAlmostEqual(angle, wanted, delta=JOINT_RAD, msg=robot["name"])
        self.assertEqual((state["world_fault"], int(state["physics_faults"])), ("", 0))


for _path in sorted(RECORDINGS.glob("*.txt")):
    setattr(Ros2Test, f"test_{_path.stem}", lambda self, path=_path: self.replay(path))

if __name__ == "__main__":
    unittest.main()
