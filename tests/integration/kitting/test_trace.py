"""Two runs of the controller side by side, by `aprsim trace diff`: reruns are the same, and a
controller that does one thing otherwise is found.

As a test: a few of each; with APRSIM_TRACE_LONG=1 fifty reruns and every mutation. `python3
test_trace.py RERUNS SEEDS [SEED]` does as many reruns as told, in virtual time and against the wall's
clock, and so many seeds of every mutation; it prints a table."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

from mutated_kitting import MUTATIONS
from running_cell import BINARIES, PATIENCE, ROOT, Daemon

HERE = pathlib.Path(__file__).resolve().parent
PACERS = "crcl.fanuc,crcl.motoman,vision.fanuc,vision.motoman"
VIRTUAL = ("--time", "virtual", "--pacers", PACERS)
POLLS = ("--clock", "polls", "--poll-ms", "25")
ORDER = """
[[kit]]
tray = "kit_m2l1_vessel"
slots = {lg_1 = "part_large_gear"}
[[kit]]
tray = "kit_s2l2_vessel"
slots = {lg_1 = "part_large_gear"}
"""
# Two programs are started by hand, so to speak, one after the other.
REAL = ("--tolerance", "time_s=5")
LONG = os.environ.get("APRSIM_TRACE_LONG", "") not in ("", "0")
RERUNS = 50 if LONG else 1
IN_TEST = tuple(MUTATIONS) if LONG else ("x_1_mm", "grip_missing", "register_value")


class Runs:
    """Journals of runs, in a folder."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.order = self.folder / "order.toml"
        self.order.write_text(ORDER, encoding="utf-8")
        self.sites = self.folder / "sites.json"
        self.count = 0

    def run(self, mutation="none", seed=1, daemon_options=VIRTUAL, controller_options=POLLS):
        """The journal of one run. The outcome of a mutated controller's job is not checked."""
        self.count += 1
        journal = self.folder / f"{self.count}_{mutation}.journal"
        daemon = Daemon(
            BINARIES, "--scene", "aprs", "--no-web", "--journal", str(journal), *daemon_options
        )
        try:
            done = subprocess.run(
                [
                    sys.executable,
                    str(HERE / "mutated_kitting.py"),
                    str(self.sites),
                    mutation,
                    str(seed),
                    "--order",
                    str(self.order),
                    "--ports-file",
                    daemon.ports_file,
                    *controller_options,
                ],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                timeout=150 * PATIENCE,
                check=False,
            )
            end(daemon)
        finally:
            daemon.close()
        if mutation == "none" and done.returncode != 0 or done.returncode == 70:
            raise AssertionError(f"{mutation} ended with {done.returncode}: {done.stdout[-3000:]}")
        return journal

    def real(self):
        """The journal of a run against the wall's clock: a program and the belt, without a camera whose
        pictures would decide anything."""
        self.count += 1
        journal = self.folder / f"{self.count}_real.journal"
        daemon = Daemon(BINARIES, "--no-web", "--journal", str(journal), "--speed", "2")
        aprsim = [os.path.join(BINARIES, "aprsim"), "--ports-file", daemon.ports_file]
        wave = ROOT / "clients" / "aprsim" / "examples" / "wave.xml"
        try:
            for command in (
                ("conveyor", "set", "--speed", "40%"),
                ("crcl", "run", str(wave), "--robot", "fanuc"),
                ("crcl", "run", str(wave), "--robot", "motoman"),
                ("conveyor", "set", "--stop"),
            ):
                subprocess.run(
                    [*aprsim, *command], check=True, stdout=subprocess.DEVNULL, timeout=60 * PATIENCE
                )
            end(daemon)
        finally:
            daemon.close()
        return journal


def end(daemon):
    """As it should: a journal that is cut off lacks the last moment."""
    daemon.process.terminate()
    daemon.process.wait(60 * PATIENCE)


def diff(a, b, *options):
    """Exit code and comparison."""
    done = subprocess.run(
        [os.path.join(BINARIES, "aprsim"), "trace", "diff", str(a), str(b), "--json", *options],
        capture_output=True,
        text=True,
        timeout=60 * PATIENCE,
        check=False,
    )
    if done.returncode not in (0, 1):
        raise AssertionError(f"trace diff: {done.returncode} {done.stderr}")
    return done.returncode, json.loads(done.stdout)


def is_named(mutation, comparison):
    """Whether one of the first deviations is of the command that is wrong."""
    kind = MUTATIONS[mutation][1]
    return any(kind in deviation["command"] for deviation in comparison["deviations"][:3])


class TraceTest(unittest.TestCase):
    def test_reruns_are_the_same_and_mutations_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            runs = Runs(folder)
            first = runs.run()
            for _ in range(RERUNS):
                code, comparison = diff(first, runs.run())
                self.assertEqual((code, comparison["deviations"]), (0, []))
            compared = {wire["name"]: wire["compared"] for wire in comparison["wires"]}
            for robot in ("crcl.fanuc", "crcl.motoman"):
                self.assertGreater(compared[robot], 20, compared)
            self.assertGreater(compared["modbus"], 0, compared)
            real = runs.real()
            for _ in range(RERUNS):
                code, comparison = diff(real, runs.real(), *REAL)
                self.assertEqual((code, comparison["deviations"]), (0, []))
            for mutation in IN_TEST:
                with self.subTest(mutation=mutation):
                    code, comparison = diff(first, runs.run(mutation))
                    self.assertEqual(code, 1)
                    self.assertFalse(comparison["same"])
                    self.assertTrue(is_named(mutation, comparison), comparison["first"])


def main(reruns, seeds, seed):
    """Exit code 0 when there is no false alarm and everything is found."""
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(folder)
        begin = time.monotonic()
        first = runs.run()
        print(f"one run takes {time.monotonic() - begin:.1f} s", flush=True)
        alarms = 0
        real = runs.real()
        for number in range(reruns):
            for what, (code, comparison) in (
                ("virtual", diff(first, runs.run())),
                ("real", diff(real, runs.real(), *REAL)),
            ):
                alarms += code
                if code:
                    text = comparison["first"]["text"]
                    print(f"rerun {number + 1} {what}: FALSE ALARM {text}", flush=True)
        print(f"{reruns} reruns of each clock, {alarms} false alarms", flush=True)
        found = named = tried = 0
        for mutation in MUTATIONS:
            for one in range(seed, seed + seeds):
                tried += 1
                code, comparison = diff(first, runs.run(mutation, one))
                found += code
                named += is_named(mutation, comparison)
                text = comparison["first"]["text"] if comparison["first"] else "NOT FOUND"
                print(f"{mutation:<24} {one:>3}  {text}", flush=True)
        print(f"{tried} mutations, {found} found, {named} named among the first three")
        return 0 if alarms == 0 and found == tried else 1


if __name__ == "__main__":
    arguments = [int(argument) for argument in sys.argv[1:]] + [1]
    sys.exit(main(arguments[0], arguments[1], arguments[2]))
