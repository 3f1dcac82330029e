"""The self-test of NIST's pendant client, replayed twenty times in virtual time. Its polls are the clock, and every run
ends in the same state, to the bit. One daemon, reset between the runs."""

import json
import pathlib
import subprocess
import time
import unittest

from test_recordings import PATIENCE_MS, RECORDINGS, WALL_S, Recording, Wire, running_cell

RUNS = 20
POLL_MS = 25  # simulated, each; the daemon's default


class Session:
    """A recording without its pauses: the client sends its next input as soon as it has its answer."""

    def __init__(self, test, daemon, recording):
        self.test, self.daemon, self.recording = test, daemon, recording
        self.wires = {}

    def run(self):
        try:
            for verb, connection, _, text in self.recording.events:
                getattr(self, f"do_{verb}")(connection, text)
            return running_cell.snapshot(self.daemon)
        finally:
            for wire in self.wires.values():
                wire.socket.close()

    def do_open(self, connection, target):
        self.wires[connection] = Wire(self.daemon.ports[target])

    def do_send(self, connection, text):
        self.wires[connection].socket.sendall(self.recording.data(text))

    def do_poll(self, connection, text):
        wire = self.wires[connection]
        wire.last_poll = self.recording.data(text)
        wire.poll()

    def do_status(self, connection, wanted):
        wire = self.wires[connection]
        number, end = wanted.split()
        other = number + (" CRCL_Error" if end == "CRCL_Done" else " CRCL_Done")
        for _ in range(PATIENCE_MS // POLL_MS):
            if wire.state() == wanted:
                return
            self.test.assertNotEqual(wire.state(), other, wire.field("StateDescription"))
            wire.poll()
        self.test.fail(f"{wire.state()} where {wanted} is expected")

    def do_close(self, connection, _):
        """Closing needs nothing here: the client has all its answers."""


class VirtualPendantTest(unittest.TestCase):
    def check(self, robot):
        recording = Recording(RECORDINGS / f"pendant_test_{robot}.txt")
        daemon = running_cell.Daemon(
            running_cell.BINARIES, *recording.options, "--no-web", "--time", "virtual", "--pacers",
            f"crcl.{robot}",
        )  # fmt: skip
        self.addCleanup(daemon.close)
        hashes, ends = set(), set()
        for _ in range(RUNS):
            self.await_place(daemon, robot)
            aprsim = [pathlib.Path(running_cell.BINARIES) / "aprsim", "--ports-file", daemon.ports_file]
            done = subprocess.run([*aprsim, "reset", "--seed", "1", "--json"], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(json.loads(done.stdout)["step"], 0)
            end = Session(self, daemon, recording).run()
            hashes.add(end["state_hash"])
            ends.add(end["step"])
            self.assertEqual(end["world_fault"], "")
            self.assertTrue(end["virtual_time"].get("reproducible"), end["virtual_time"])
        self.assertEqual((len(hashes), len(ends)), (1, 1), (hashes, ends))
        # The self-test takes more than five simulated seconds.
        self.assertGreater(int(ends.pop()), 5000)

    def await_place(self, daemon, robot):
        """Waits until the previous session has left."""
        deadline = time.monotonic() + WALL_S
        while f"crcl.{robot}" not in running_cell.snapshot(daemon)["virtual_time"].get("awaited", []):
            self.assertLess(time.monotonic(), deadline)

    def test_fanuc(self):
        self.check("fanuc")

    def test_motoman(self):
        self.check("motoman")


if __name__ == "__main__":
    unittest.main()
