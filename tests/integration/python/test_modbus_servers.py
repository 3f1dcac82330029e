"""Modbus servers of a scene: values read and written by a client, replays, refusals, ports."""

import json
import os
import pathlib
import socket
import struct
import subprocess
import tempfile
import unittest

from aprsim import AprsimError, Cell, Daemon
from running_cell import PATIENCE, ROOT

BINARIES = pathlib.Path(os.environ["APRSIM_BIN_DIR"])
EXTENSIONS = BINARIES.parent / "extensions"
LINE = str(ROOT / "clients" / "devices" / "line.yaml")


class Modbus:
    """A client of Modbus/TCP, after the specification alone."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=60 * PATIENCE)
        self.transaction = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def ask(self, *body):
        """The PDU of the answer to a PDU of words behind its function."""
        return self.ask_bytes(bytes([body[0]]) + b"".join(struct.pack(">H", word) for word in body[1:]))

    def ask_bytes(self, pdu):
        self.transaction += 1
        self.socket.sendall(struct.pack(">HHHB", self.transaction, 0, len(pdu) + 1, 1) + pdu)
        head = self.receive(7)
        transaction, protocol, length, _ = struct.unpack(">HHHB", head)
        assert (transaction, protocol) == (self.transaction, 0), head
        return self.receive(length - 1)

    def receive(self, size):
        data = b""
        while len(data) < size:
            more = self.socket.recv(size - len(data))
            assert more, "the server has closed"
            data += more
        return data

    def words(self, function, address, count):
        answer = self.ask(function, address, count)
        assert answer[0] == function and answer[1] == 2 * count, answer
        return answer[2:]

    def bits(self, function, address, count):
        answer = self.ask(function, address, count)
        assert answer[0] == function, answer
        return [answer[2 + i // 8] >> (i % 8) & 1 for i in range(count)]

    def write_words(self, address, *values):
        head = struct.pack(">BHHB", 16, address, len(values), 2 * len(values))
        return self.ask_bytes(head + b"".join(struct.pack(">H", value) for value in values))


def aprsim(*arguments):
    environment = dict(os.environ, APRSIM_EXTENSIONS=str(EXTENSIONS))
    return subprocess.run(
        [BINARIES / "aprsim", *arguments], env=environment, capture_output=True, text=True
    )


class ModbusServersTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.directory = pathlib.Path(directory.name)

    def daemon(self, *arguments, scene=LINE, speed="stepped"):
        return Daemon(
            "--no-web",
            "--extensions",
            str(EXTENSIONS),
            *arguments,
            scene=scene,
            speed=speed,
            start_s=60 * PATIENCE,
        )

    def ports(self, served):
        return json.loads(pathlib.Path(served.ports_file).read_text())

    def test_a_program_weighs_and_pushes_and_the_journal_replays(self):
        journal = str(self.directory / "run.journal")
        with (
            self.daemon("--journal", journal) as served,
            Cell.connect(served.ports_file) as cell,
            Modbus(self.ports(served)["modbus.line"]) as plc,
        ):
            self.assertEqual(plc.write_words(0, 300), struct.pack(">BHH", 16, 0, 1))
            self.assertEqual(plc.ask(5, 0, 0xFF00), struct.pack(">BHH", 5, 0, 0xFF00))
            self.assertEqual(plc.bits(1, 0, 4), [1, 1, 0, 0])
            cell.step(4000)
            now = cell.snapshot()
            (mass_kg,) = struct.unpack(">f", plc.words(4, 0, 2))
            self.assertAlmostEqual(mass_kg, now.device("scale").signals["mass_kg"], places=6)
            self.assertAlmostEqual(mass_kg, 0.2204, places=4)
            travel, speed, fault = struct.unpack(">ihH", plc.words(4, 2, 4))
            self.assertAlmostEqual(travel * 1e-4, now.conveyor.travel_m, delta=5.1e-5)
            self.assertAlmostEqual(speed * 1e-3, now.conveyor.speed_m_s, delta=5.1e-4)
            self.assertEqual(fault, 0)
            low, high = struct.unpack(">HH", plc.words(4, 6, 2))
            self.assertEqual((high << 16) + low, 4000)
            # It stops the belt, and pushes the tray off.
            self.assertEqual(plc.ask(5, 0, 0), struct.pack(">BHH", 5, 0, 0))
            cell.step(1000)
            plc.ask(6, 10, 250)
            self.assertEqual(plc.words(3, 10, 1), struct.pack(">H", 250))
            start = cell.snapshot().bodies["small_gear_vessel_1"].position_m[1]
            now = cell.step(200)
            self.assertEqual(now.device("pusher").signals["force_n"], 2.5)
            self.assertEqual(plc.bits(2, 0, 1), [1])
            self.assertGreater(now.bodies["small_gear_vessel_1"].position_m[1], start + 0.01)
            plc.ask(6, 10, 0)
            plc.ask(5, 2, 0xFF00)
            cell.step(100)
            self.assertEqual(struct.unpack(">H", plc.words(4, 5, 1)), (1,))
        replayed = aprsim("replay", journal)
        self.assertEqual(replayed.returncode, 0, replayed.stderr)
        self.assertIn("all states are the same", replayed.stdout)

    def test_refuses_what_the_map_does_not_have(self):
        with (
            self.daemon() as served,
            Modbus(self.ports(served)["modbus.line"]) as plc,
            Modbus(self.ports(served)["modbus"]) as conveyor,
        ):
            for pdu, exception in {
                (3, 0x8000, 1): 2,  # the conveyor's own
                (4, 8, 1): 2,
                (4, 0, 9): 2,
                (3, 0, 2): 2,  # a gap
                (6, 1, 0): 2,
                (5, 0x8000, 0xFF00): 2,
                (6, 0, 400): 3,  # faster than the belt
                (6, 10, 501): 3,  # stronger than the pusher
                (3, 0, 0): 3,
                (9, 0, 0): 1,
            }.items():
                self.assertEqual(plc.ask(*pdu), bytes([pdu[0] | 0x80, exception]), pdu)
            self.assertEqual(plc.bits(1, 0, 4), [0, 1, 0, 0])
            self.assertEqual(conveyor.words(3, 0x8000, 3), struct.pack(">HHH", 0, 1, 0))
            self.assertEqual(conveyor.ask(3, 0, 1), bytes([0x83, 2]))

    def test_the_command_line_prints_each_map(self):
        with self.daemon() as served:
            given = ["--ports-file", str(served.ports_file)]
            text = aprsim("modbus", "map", "line", *given)
            self.assertEqual(text.returncode, 0, text.stderr)
            for line in (
                "Coils (FC 1 reads, FC 5 and 15 write)",
                "  0           RW bit                              belt.run: ",
                "  10          RW uint16              0.01 N       pusher.force_n: ",
                "  0-1         R  float32, high_first 1            scale.mass_kg: ",
                "  6-7         R  uint32, low_first   0.001 s      cell.time_s: ",
            ):
                self.assertIn(line, text.stdout)
            objects = [
                json.loads(line)
                for line in aprsim("modbus", "map", "--json", *given).stdout.splitlines()
            ]
            self.assertEqual(len(objects), 12)
            unknown = aprsim("modbus", "map", "press", *given)
            self.assertEqual(unknown.returncode, 2)
            self.assertIn("no Modbus server 'press' in scene line; there is line", unknown.stderr)

    def test_the_server_conforms_with_its_map(self):
        with self.daemon(speed="max") as served:
            given = ["--ports-file", str(served.ports_file)]
            done = aprsim("conform", "modbus", "--server", "line", "--allow-motion", "--json", *given)
            lines = [json.loads(line) for line in done.stdout.splitlines()]
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertGreater(lines[-1]["passed"], 50)
            self.assertEqual((lines[-1]["failed"], lines[-1]["not_checked"]), (0, 0))
            # A map that the server does not have is noticed.
            port = self.ports(served)["modbus"]
            other = aprsim("conform", "modbus", f"127.0.0.1:{port}", "--server", "line", *given)
            self.assertEqual(other.returncode, 1, other.stdout)
            unknown = aprsim("conform", "modbus", "--server", "press", *given)
            self.assertEqual(unknown.returncode, 2)
            self.assertIn("no Modbus server 'press' in scene line", unknown.stderr)

    def test_the_map_follows_the_scene(self):
        with (
            self.daemon() as served,
            Cell.connect(served.ports_file) as cell,
            Modbus(self.ports(served)["modbus.line"]) as plc,
        ):
            self.assertEqual(plc.bits(1, 0, 1), [0])
            text = pathlib.Path(LINE).read_text()
            cell.reset(scene_text=text.replace("{area: coil, address: 0,", "{area: coil, address: 7,"))
            self.assertEqual(plc.ask(1, 7, 1), bytes([1, 1, 0]))
            self.assertEqual(plc.ask(1, 0, 1), bytes([0x81, 2]))

    def test_a_configured_port_is_used_or_named(self):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = taken.getsockname()[1]
            given = ["--no-web", "--extensions", str(EXTENSIONS), "--scene", LINE]
            for key in ("grpc.port=0", "modbus.port=0", f"modbus.ports.line={port}"):
                given += ["--set", key]
            refused = subprocess.run([BINARIES / "aprsimd", *given], capture_output=True, text=True)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("modbus.line", refused.stderr)
        self.assertIn("modbus.ports.line", refused.stderr)

    def test_signals_of_devices_are_checked_where_they_are_made(self):
        for signal, error in {
            "scale.weight": 'found "scale.weight", expected a signal of device scale: mass_kg, full',
            "scale.mass_kg, access: write": "access: found write, expected read: scale.mass_kg is only read",
            "pusher.force_n, scale: 0.00001": "scale: found 1e-05, expected one with which the "
            "encoding holds 0 to 5 of pusher.force_n; 5 would be the count 5",
        }.items():
            path = self.directory / "line.yaml"
            text = pathlib.Path(LINE).read_text()
            path.write_text(text + f"      - {{area: holding, address: 99, signal: {signal}}}\n")
            with self.assertRaises(AprsimError) as raised:
                self.daemon(scene=str(path))
            self.assertIn("line.yaml:", str(raised.exception))
            self.assertIn("modbus_servers[0].registers[12].signal: ", str(raised.exception))
            self.assertIn(error, str(raised.exception))


if __name__ == "__main__":
    unittest.main()
