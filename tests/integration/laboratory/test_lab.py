"""The cell at the addresses of the laboratory, by server/lab in a network namespace of its own. Where namespaces
are not permitted the tests are skipped and say so."""

import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import time
import unittest
import urllib.request

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
LAB = ROOT / "server" / "lab"
PATIENCE = float(os.environ.get("APRSIM_PATIENCE", "1"))
NOT_PERMITTED = 4


def lab(*arguments):
    """Runs server/lab to its end."""
    done = subprocess.run(
        [sys.executable, str(LAB), *arguments],
        capture_output=True,
        text=True,
        timeout=120 * PATIENCE,
    )
    if done.returncode == NOT_PERMITTED:
        raise unittest.SkipTest(done.stderr.strip())
    return done


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return listener.getsockname()[1]


class LabTest(unittest.TestCase):
    def test_robots_and_belt_answer_at_their_addresses(self):
        done = lab("--page", "0", "--grpc", "0", "--", sys.executable, str(HERE / "clients.py"))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        found = json.loads(done.stdout.splitlines()[-1])
        self.assertEqual(found["fanuc_state"], [40, 56])
        self.assertEqual(found["motoman_state"], [40, 144])
        self.assertEqual(found["gripper"], 0)
        self.assertEqual(found["refused"], [])
        # Pictures as Axis cameras send them.
        self.assertEqual(found["pictures"], {f"192.168.1.{last}": "200 JPEG" for last in (104, 105, 107, 108, 110)})

    def test_transfer_by_the_belt(self):
        """The laboratory's transfer: half speed, direction 1, 5 s of the cell's time, towards the Motoman."""
        done = lab(
            "--scene", "aprs_2024", "--page", "0", "--grpc", "0", "--option=--speed=max", "--",
            sys.executable, str(HERE / "clients.py"), "transfer",
        )  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        found = json.loads(done.stdout.splitlines()[-1])
        self.assertGreater(found["travel_m"], 0.3)
        self.assertEqual(found["trays_moved_against_x"], [])
        self.assertTrue(found["trays_moved"])

    def test_without_root(self):
        """The addresses answer in a user namespace, too."""
        done = lab(
            "--as-user", "--page", "0", "--grpc", "0", "--", sys.executable, str(HERE / "clients.py"),
        )  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("in a user namespace", done.stdout)

    def test_exit_code_is_that_of_the_command(self):
        self.assertEqual(lab("--page", "0", "--grpc", "0", "--", "sh", "-c", "exit 7").returncode, 7)

    def test_wrong_arguments(self):
        done = lab("--daemon", "/nowhere/aprsimd")
        self.assertEqual(done.returncode, 2)
        self.assertIn("/nowhere/aprsimd is not a program", done.stderr)
        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = taken.getsockname()[1]
            done = lab("--page", str(port), "--grpc", "0", "--", "true")
        self.assertEqual(done.returncode, 2)
        self.assertIn(f"port {port} of this machine", done.stderr)

    def test_a_daemon_that_does_not_start_is_reported(self):
        done = lab("--page", "0", "--grpc", "0", "--scene", "nowhere", "--", "true")
        self.assertEqual(done.returncode, 1)
        self.assertIn("nowhere", done.stderr)

    def test_page_is_reachable_from_outside(self):
        port = free_port()
        served = subprocess.Popen(
            [sys.executable, str(LAB), "--page", str(port), "--grpc", "0", "--serve"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.addCleanup(served.stdout.close)
        self.addCleanup(lambda: served.poll() is None and served.kill())
        lines = []
        for line in served.stdout:
            lines.append(line)
            if f"127.0.0.1:{port}" in line:
                break
        else:
            if served.wait() == NOT_PERMITTED:
                self.skipTest("".join(lines))
            self.fail("".join(lines))
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/healthz", timeout=30) as answer:
            self.assertEqual(answer.status, 200)
        # The robots' ports are inside only.
        with self.assertRaises(OSError):
            socket.create_connection(("127.0.0.1", 11002), 1).close()
        served.send_signal(signal.SIGTERM)
        deadline = time.monotonic() + 20 * PATIENCE
        for _ in served.stdout:
            self.assertLess(time.monotonic(), deadline)
        self.assertEqual(served.wait(20 * PATIENCE), 0)


if __name__ == "__main__":
    unittest.main()
