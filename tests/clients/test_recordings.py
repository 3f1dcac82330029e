"""Replays of short sessions of NIST's controllers (recordings/, made by record.py). The recorded input is sent byte for
byte and read by read, at the same simulated times. The replies must lead through the whole session, and the cell must
end in the recorded state. CRCL statuses are compared by the fields that the controllers wait for, not by their text."""

import math
import pathlib
import re
import select
import socket
import struct
import sys
import time
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "integration" / "kitting"))

import running_cell  # noqa: E402

Crcl, Http2 = running_cell._attack_cell.Crcl, running_cell._attack_cell.Http2
RECORDINGS = HERE / "recordings"
POLL_MS = 20  # simulated, between polls while a command is waited for
PATIENCE_MS = 30_000  # simulated, for one of them
WALL_S = 30 * running_cell.PATIENCE
TOOL_MM, GEAR_MM, BELT_M = 0.1, 1.5, 0.005


class Recording:
    """A file of recordings/: options of the daemon, events, and final positions."""

    def __init__(self, path):
        self.options, self.events, self.phrases = [], [], {}
        self.tools, self.gears, self.belt = {}, {}, None
        for line in path.read_text(encoding="ascii").splitlines():
            verb, _, rest = line.partition(" ")
            if verb == "option":
                self.options.append(rest)
            elif verb == "phrase":
                self.phrases[rest[0]] = rest[2:]
            elif verb in ("tool", "gear"):
                name, *place = rest.split()
                (self.tools if verb == "tool" else self.gears)[name] = [float(value) for value in place]
            elif verb == "belt":
                self.belt = float(rest)
            elif verb != "#":
                connection, gap_ms, *text = rest.split(" ", 2)
                self.events.append((verb, int(connection), int(gap_ms), text[0] if text else ""))

    def data(self, text):
        """The bytes of printable characters, \\xNN and phrases."""
        text = re.sub(r"\\([A-Z])", lambda found: self.phrases[found.group(1)], text)
        return re.sub(rb"\\x(..)", lambda found: bytes([int(found.group(1), 16)]), text.encode())


class Stepper:
    """gRPC's Step, over one connection."""

    METHOD = b"/aprsim.v1.ControlService/Step"

    def __init__(self, port):
        self.http = Http2(port, WALL_S)
        # Windows that no number of small answers fills, and no acknowledgement that is missing.
        self.http.socket.sendall(Http2.frame(8, 0, 0, struct.pack(">I", 1 << 30)))
        self.buffer = b""

    def step(self, count):
        message = b"\x08"
        while count > 0x7F:
            message += bytes([count & 0x7F | 0x80])
            count >>= 7
        self.http.socket.sendall(self.http.call(self.METHOD, message + bytes([count])))
        while True:
            kind, flags, stream, _ = self._frame()
            if kind == Http2.HEADERS and stream == self.http.stream and flags & Http2.END_STREAM:
                return
            if kind in (Http2.RST_STREAM, 7):
                raise ConnectionError("gRPC has refused a step")

    def _frame(self):
        while True:
            size = int.from_bytes(self.buffer[:3], "big")
            if len(self.buffer) >= 9 + size:
                break
            data = self.http.socket.recv(1 << 16)
            if not data:
                raise ConnectionError("gRPC has closed")
            self.buffer += data
        kind, flags, stream = struct.unpack(">BBI", self.buffer[3:9])
        payload, self.buffer = self.buffer[9 : 9 + size], self.buffer[9 + size :]
        if kind in (Http2.SETTINGS, Http2.PING) and not flags & 1:
            answer = payload if kind == Http2.PING else b""
            self.http.socket.sendall(Http2.frame(kind, 1, 0, answer))
        return kind, flags, stream, payload

    def close(self):
        self.http.close()


class Wire:
    """A connection of the client, with its unused input."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), WALL_S)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.read = b""
        self.last_poll = None
        self.status = ""

    def take(self, seconds):
        """Reads available input, or what arrives within that time."""
        while select.select([self.socket], [], [], seconds)[0]:
            data = self.socket.recv(1 << 16)
            if not data:
                return
            self.read += data
            seconds = 0

    def poll(self):
        self.socket.sendall(self.last_poll)
        while b"</CRCLStatus>" not in self.read:
            data = self.socket.recv(1 << 16)
            if not data:
                raise ConnectionError("closed while a status was expected")
            self.read += data
        status, _, self.read = self.read.partition(b"</CRCLStatus>")
        self.status = status.decode()

    def field(self, name):
        found = re.search(f"<{name}>([^<]*)<", self.status)
        return found.group(1) if found else ""

    def state(self):
        return f"{self.field('CommandID')} {self.field('CommandState')}"


class RecordingTest(unittest.TestCase):
    def replay(self, path):
        self.recording = Recording(path)
        self.daemon = running_cell.Daemon(
            running_cell.BINARIES, *self.recording.options, "--speed", "stepped", "--no-web"
        )
        self.addCleanup(self.daemon.close)
        self.stepper = Stepper(self.daemon.ports["grpc"])
        self.addCleanup(self.stepper.close)
        self.observer = Crcl(self.daemon.ports["crcl.fanuc"], WALL_S)
        self.addCleanup(self.observer.close)
        self.wires = {}
        before = running_cell.snapshot(self.daemon)
        for verb, connection, gap_ms, text in self.recording.events:
            try:
                getattr(self, f"do_{verb}")(connection, gap_ms, text)
            except (AssertionError, OSError) as fault:
                self.fail(f"{fault} at: {verb} {connection} {text[:300]}")
        self.step(500)
        self.check_end(before, running_cell.snapshot(self.daemon))

    def step(self, milliseconds):
        if milliseconds:
            self.stepper.step(milliseconds)
        for wire in self.wires.values():
            if wire.last_poll is None:
                wire.take(0)

    def do_open(self, connection, gap_ms, target):
        self.step(gap_ms)
        self.wires[connection] = wire = Wire(self.daemon.ports[target])
        self.addCleanup(wire.socket.close)

    def do_send(self, connection, gap_ms, text):
        self.step(gap_ms)
        self.wires[connection].socket.sendall(self.recording.data(text))
        # A listener reads its connections in turns: after two polls on another connection it has read the bytes sent
        # before.
        self.observer.status()
        self.observer.status()

    def do_poll(self, connection, _, text):
        wire = self.wires[connection]
        wire.last_poll = self.recording.data(text)
        wire.poll()

    def do_status(self, connection, _, wanted):
        """Polls until the command has ended as recorded."""
        wire = self.wires[connection]
        number, end = wanted.split()
        other = number + (" CRCL_Error" if end == "CRCL_Done" else " CRCL_Done")
        waited = 0
        while wire.state() != wanted:
            self.assertNotEqual(wire.state(), other, wire.field("StateDescription"))
            self.assertLess(waited, PATIENCE_MS, wire.state())
            self.step(POLL_MS)
            waited += POLL_MS
            wire.poll()

    def do_answer(self, connection, _, text):
        """Expects exactly these bytes. A write is answered once a step has applied it: the next one, or a later one if the
        write arrives late."""
        wire, wanted = self.wires[connection], self.recording.data(text)
        deadline = time.monotonic() + WALL_S
        while len(wire.read) < len(wanted):
            self.assertLess(time.monotonic(), deadline)
            self.stepper.step(1)
            wire.take(0.2)
        self.assertEqual(wire.read[: len(wanted)], wanted)
        wire.read = wire.read[len(wanted) :]

    def do_seen(self, connection, _, names):
        """Expects a line of the camera with these objects in this order."""
        wire = self.wires[connection]
        waited = 0
        while b"\n" not in wire.read:
            self.assertLess(waited, PATIENCE_MS)
            self.step(10)
            waited += 10
            wire.take(0.05)
        line, _, wire.read = wire.read.partition(b"\n")
        self.assertEqual(",".join(line.decode().split(",")[:-1:6]), names)

    def do_close(self, connection, gap_ms, _):
        self.step(gap_ms)
        self.wires[connection].socket.shutdown(socket.SHUT_WR)

    def check_end(self, before, end):
        self.assertEqual(end["world_fault"], "")
        self.assertEqual(int(end["physics_faults"]), 0)
        for robot in end["robots"]:
            self.assertFalse(robot["protective_stop"], robot["name"])
            place = self.mm(robot["tool_in_reference"])
            self.assertLess(math.dist(place, self.recording.tools[robot["name"]]), TOOL_MM, (robot["name"], place))
        was = {body["name"]: self.mm(body["body_in_world"]) for body in before["bodies"]}
        for body in end["bodies"]:
            if body["type"].endswith("_gear"):
                place = self.mm(body["body_in_world"])
                wanted = self.recording.gears.get(body["name"], was[body["name"]])
                self.assertLess(math.dist(place, wanted), GEAR_MM, (body["name"], place, wanted))
        if self.recording.belt is not None:
            self.assertAlmostEqual(end["conveyor"].get("travel_m", 0.0), self.recording.belt, delta=BELT_M)

    @staticmethod
    def mm(pose):
        return [1e3 * pose["position_m"].get(axis, 0.0) for axis in "xyz"]


for _path in sorted(RECORDINGS.glob("*.txt")):
    setattr(RecordingTest, f"test_{_path.stem}", lambda self, path=_path: self.replay(path))

if __name__ == "__main__":
    unittest.main()
