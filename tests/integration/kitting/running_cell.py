"""The daemon as the kitting controller's tests see it, and what the controller must not: where
everything really is."""

import importlib.util
import json
import math
import os
import pathlib
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
BINARIES = os.environ.get("APRSIM_BIN_DIR", str(ROOT / "build" / "release" / "bin"))
PATIENCE = float(os.environ.get("APRSIM_PATIENCE", "1"))  # factor on deadlines
CONTROLLER = ROOT / "clients" / "kitting"
sys.path.insert(0, str(CONTROLLER))

_spec = importlib.util.spec_from_file_location("attack_cell", ROOT / "tests" / "attack" / "cell.py")
_attack_cell = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(_attack_cell)
Daemon = _attack_cell.Daemon

from vision import canonical  # noqa: E402


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


def snapshot(daemon):
    """The output of `aprsim status --json`."""
    done = subprocess.run(
        [os.path.join(BINARIES, "aprsim"), "--ports-file", daemon.ports_file, "status", "--json"],
        capture_output=True,
        text=True,
        timeout=60 * PATIENCE,
    )
    # A pace below the one asked for, on a busy machine, is a problem, too, and none of ours.
    if done.returncode not in (0, 1):
        raise AssertionError(f"aprsim status: {done.stderr} {daemon.log_text()[-2000:]}")
    return json.loads(done.stdout)


def filled_slots(state, cell):
    """For every kit tray: the type of each slot's part and its distance from the slot's centre [mm];
    None where no part is within 3 mm."""
    bodies = [(body, _position(body)) for body in state["bodies"]]
    kits = {}
    for body, (x, y, z) in bodies:
        tray = cell.trays.get(canonical(body["type"]))
        if tray is None or not tray.is_kit:
            continue
        turn = body["body_in_world"]["orientation"]
        yaw = 2 * math.atan2(turn["z"], turn["w"])
        kits[body["name"]] = {}
        for slot in tray.slots:
            u, v = slot.xy_mm
            centre = (
                x + u * math.cos(yaw) - v * math.sin(yaw),
                y + u * math.sin(yaw) + v * math.cos(yaw),
                z,
            )
            near = [
                (math.dist(centre, at), canonical(other["type"]))
                for other, at in bodies
                if canonical(other["type"]) in cell.gears
            ]
            error, kind = min(near)
            kits[body["name"]][slot.name] = (kind, error) if error < 3 else None
    return kits


def _position(body):
    at = body["body_in_world"]["position_m"]
    return tuple(1e3 * at.get(axis, 0.0) for axis in "xyz")


class Controller:
    """The controller as its users start it."""

    def __init__(self, *arguments, ports_file):
        self.report_file = pathlib.Path(ports_file).with_name(f"report-{time.monotonic_ns()}.json")
        self.process = subprocess.Popen(
            [
                sys.executable,
                str(CONTROLLER / "kitting"),
                "--ports-file",
                str(ports_file),
                "--report",
                str(self.report_file),
                "--poll-ms",
                "5",
                *arguments,
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.lines = []

    def read_until(self, *words):
        """Reads what it prints until a line has all these words."""
        for line in self.process.stdout:
            self.lines.append(line)
            if all(word in line for word in words):
                return line
        raise AssertionError(f"it ended without saying {words}: {''.join(self.lines[-30:])}")

    def wait(self, seconds=120):
        """Its exit code and report."""
        try:
            out, _ = self.process.communicate(timeout=seconds * PATIENCE)
        except subprocess.TimeoutExpired:
            self.kill()
            raise AssertionError(
                f"no end within {seconds * PATIENCE:g} s: {''.join(self.lines[-30:])}"
            ) from None
        self.lines += out.splitlines(keepends=True)
        return self.process.returncode, json.loads(self.report_file.read_text(encoding="utf-8"))

    def kill(self):
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()
        self.process.stdout.close()
