"""The unit of systemd: its form, its exposure, and its filter of system calls, which a session with all
wires neither exceeds nor leaves much of. No systemd runs here."""

import errno
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

import unit_sandbox

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "attack"), str(ROOT / "tests" / "integration" / "access")]

from authority import Authority  # noqa: E402
from cell import Crcl, Daemon, Modbus  # noqa: E402

UNIT = ROOT / "server" / "aprsimd.service"
BINARIES = os.environ.get("APRSIM_BIN_DIR", str(ROOT / "build" / "release" / "bin"))
PATIENCE = float(os.environ.get("APRSIM_PATIENCE", "1"))
LARGEST_EXPOSURE = 2.0
# Groups that hold nothing for a simulator.
DENIED = ("@clock", "@cpu-emulation", "@debug", "@keyring", "@module", "@mount", "@obsolete", "@privileged",
          "@raw-io", "@reboot", "@setuid", "@swap", "@chown", "@aio", "@memlock")
SETTINGS = {
    "DynamicUser": "yes",
    "ProtectSystem": "strict",
    "NoNewPrivileges": "yes",
    "MemoryMax": "1G",
    "WatchdogSec": "10",
    "CapabilityBoundingSet": "CAP_NET_BIND_SERVICE",
    "AmbientCapabilities": "CAP_NET_BIND_SERVICE",
    "StateDirectoryMode": "0700",
    "SystemCallArchitectures": "native",
}


def eventually(condition, seconds, what):
    """Waits for a condition; what it returned."""
    deadline = time.monotonic() + seconds * PATIENCE
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > deadline:
            raise AssertionError(f"not within {seconds * PATIENCE:g} s: {what}")
        time.sleep(0.02)


class FormTest(unittest.TestCase):
    def test_systemd_has_nothing_to_say(self):
        with tempfile.TemporaryDirectory() as folder:
            copy = pathlib.Path(folder) / UNIT.name
            text = UNIT.read_text(encoding="utf-8").replace("/usr/bin/aprsimd", f"{BINARIES}/aprsimd")
            copy.write_text(text, encoding="utf-8")
            done = subprocess.run(
                ["systemd-analyze", "verify", "--man=no", str(copy)], capture_output=True, text=True
            )
        self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""))

    def test_exposure_is_low(self):
        done = subprocess.run(
            ["systemd-analyze", "--no-pager", "security", "--offline=true", str(UNIT)],
            capture_output=True,
            text=True,
        )
        found = re.search(r"Overall exposure level for aprsimd\.service: ([\d.]+)", done.stdout)
        self.assertIsNotNone(found, done.stdout + done.stderr)
        print(f"exposure: {found.group(1)} of 10")
        self.assertLessEqual(float(found.group(1)), LARGEST_EXPOSURE)

    def test_settings(self):
        unit = unit_sandbox.read_unit(UNIT)
        for key, value in SETTINGS.items():
            self.assertEqual(unit.get(key), [value], key)


class Session:
    """Everything that a service does: all wires, the demo that the daemon starts, pictures, saved
    states, a journal, reloading, TLS. `options()` are those of the next daemon (cell.Daemon)."""

    def __init__(self, test, options):
        self.test, self.options = test, options
        folder = test.enterContext(tempfile.TemporaryDirectory())
        self.folder = pathlib.Path(folder)

    def run(self):
        self._plain()
        self._encrypted()

    def _start(self, *arguments):
        daemon = Daemon(BINARIES, "--scene", "aprs_2024", "--speed", "5", *arguments, **self.options())
        self.test.addCleanup(daemon.close)
        return daemon

    def _aprsim(self, daemon, *arguments):
        done = subprocess.run(
            [os.path.join(BINARIES, "aprsim"), "--ports-file", daemon.ports_file, *arguments],
            capture_output=True,
            text=True,
            timeout=120 * PATIENCE,
        )
        # A pace below the one asked for is a problem of `status`, and none of ours.
        allowed = (0, 1) if "status" in arguments else (0,)
        self.test.assertIn(
            done.returncode, allowed, f"{arguments}: {done.stderr} {daemon.log_text()[-1500:]}"
        )
        return done.stdout

    def _plain(self):
        configuration = self.folder / "aprsim.yaml"
        configuration.write_text("log_level: info\n", encoding="utf-8")
        daemon = self._start(
            "--config", str(configuration), "--journal", str(self.folder / "run.aprsimj"), "--demo",
            "--set", f"access.audit_file={self.folder / 'audit'}",
        )
        self._aprsim(daemon, "events", "--after", "0", "--kind", "grasped", "--count", "1")
        crcl = Crcl(daemon.ports["crcl.fanuc"])
        self.test.assertIn("CommandStatus", crcl.status())
        crcl.close()
        modbus = Modbus(daemon.ports["modbus"])
        self.test.assertEqual(modbus.write_coil(Modbus.STOP, False), 0)
        modbus.close()
        for wire in ("vision.fanuc", "state.fanuc", "state.motoman"):
            with socket.create_connection(("127.0.0.1", daemon.ports[wire]), 30 * PATIENCE) as client:
                self.test.assertTrue(client.recv(1 << 16), wire)
        for wire in ("motion.fanuc", "motion.motoman", "gripper.fanuc"):
            with socket.create_connection(("127.0.0.1", daemon.ports[wire]), 30 * PATIENCE) as client:
                client.sendall(b"\0" * 40)
        page = f"http://127.0.0.1:{daemon.ports['web']}"
        for place in ("/", "/metrics", "/healthz"):
            with urllib.request.urlopen(page + place, timeout=60 * PATIENCE) as answer:
                self.test.assertTrue(answer.read())
        camera = f"http://127.0.0.1:{daemon.ports['camera.fanuc_table']}/axis-cgi/jpg/image.cgi"
        with urllib.request.urlopen(camera, timeout=60 * PATIENCE) as answer:
            self.test.assertTrue(answer.read().startswith(b"\xff\xd8"))
        self._aprsim(daemon, "watch", "--count", "3", "--json")
        self._aprsim(daemon, "save", "one", "--file", str(self.folder / "one.state"))
        self._aprsim(daemon, "fault", "inject", "belt-slip", "--share", "0.5")
        self._aprsim(daemon, "incident", "--last", "5s", "--file", str(self.folder / "incident"))
        self._aprsim(daemon, "load", "one")
        self._aprsim(daemon, "reset")
        daemon.process.send_signal(signal.SIGHUP)
        eventually(lambda: re.search(r"reload|configuration", daemon.log_text().split("listening")[-1]), 30,
                   "the configuration is read again")
        self._end(daemon)

    def _encrypted(self):
        authority = Authority(str(self.folder))
        own = authority.certify("localhost", "DNS:localhost,IP:127.0.0.1")
        daemon = self._start("--set", f"tls.certificate={own.certificate}", "--set", f"tls.key={own.key}")
        self._aprsim(daemon, "--ca", authority.certificate, "status")
        self._end(daemon)

    def _end(self, daemon):
        code, _ = daemon.stop()
        self.test.assertEqual(code, 0, daemon.log_text()[-2000:])


class FilterTest(unittest.TestCase):
    def setUp(self):
        self.unit = unit_sandbox.read_unit(UNIT)
        self.known = unit_sandbox.groups()

    def test_dangerous_groups_are_denied(self):
        allowed = unit_sandbox.allowed_calls(self.unit, self.known)
        for group in DENIED:
            # @default is allowed always.
            calls = unit_sandbox.expand(group, self.known) - unit_sandbox.expand("@default", self.known)
            self.assertEqual(calls & allowed, set(), group)

    def test_it_holds(self):
        # A memory that may be written and run, a namespace, an exotic socket, another user, a trace.
        tried = """
import ctypes, errno, mmap, os, socket
libc = ctypes.CDLL(None, use_errno=True)
def code(call):
    try:
        call()
    except OSError as error:
        return error.errno
    return 0
def trace():
    if libc.ptrace(0, 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), "")
def namespace():
    if libc.unshare(0x10000000) != 0:
        raise OSError(ctypes.get_errno(), "")
print(code(lambda: mmap.mmap(-1, 4096, prot=mmap.PROT_WRITE | mmap.PROT_EXEC)), code(trace), code(namespace),
      code(lambda: socket.socket(socket.AF_PACKET, socket.SOCK_RAW)), code(lambda: os.setuid(os.getuid())),
      code(lambda: os.chown("/tmp", -1, -1)), code(lambda: os.chroot("/")),
      code(lambda: mmap.mmap(-1, 4096)), code(lambda: socket.socket().close()))
"""
        own = unit_sandbox.Filter(self.unit, unit_sandbox.REFUSE)
        done = subprocess.run(
            [sys.executable, "-c", tried], capture_output=True, text=True, preexec_fn=own.enter
        )
        refused = str(errno.EPERM)
        self.assertEqual(done.stdout.split(), [refused] * 7 + ["0", "0"], done.stderr)

    def test_a_session_with_all_wires_needs_no_other_call(self):
        # One that is not allowed kills the process here; the unit lets it fail with EPERM.
        Session(self, lambda: {"enter": unit_sandbox.Filter(self.unit).enter}).run()

    def test_most_of_it_is_used(self):
        tables = []

        def traced():
            tables.append(pathlib.Path(folder) / f"calls-{len(tables)}")
            # Traced by its grandchild: the daemon stays our child.
            return {"before": ("strace", "-D", "-f", "-c", "-U", "name", "-o", str(tables[-1]))}

        with tempfile.TemporaryDirectory() as folder:
            Session(self, traced).run()
            words = []
            for table in tables:
                eventually(lambda t=table: t.exists() and t.stat().st_size, 30, "a table of calls")
                words += table.read_text(encoding="utf-8").split()
        used = {word for word in words if re.fullmatch(r"[a-z_0-9]+", word)} - {"syscall", "total"}
        self.assertLessEqual({"execve", "pipe2", "setpriority", "timerfd_settime"}, used)
        allowed = unit_sandbox.allowed_calls(self.unit, self.known)
        self.assertEqual(used - allowed, set(), "used and not allowed")
        unused = [
            group
            for group in sorted(self.known)
            if (calls := unit_sandbox.expand(group, self.known)) & allowed and not calls & used
        ]
        print(f"{len(used)} of {len(allowed)} allowed system calls are used")
        print("used:", " ".join(sorted(used)))
        print("groups of which something is allowed and nothing used:", " ".join(unused) or "none")


if __name__ == "__main__":
    unittest.main()
