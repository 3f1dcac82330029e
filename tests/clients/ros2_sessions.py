#!/usr/bin/env python3
"""Runs drivers of the laboratory's ROS 2 controllers against the daemon, at the addresses of the laboratory in a
network namespace of its own, and keeps all that goes over the wires.

usage: tests/clients/ros2_sessions.py --keep FOLDER PROGRAM [WORD...]
  --keep FOLDER  folder for the exchange of each session, the input of record_ros2.py
  PROGRAM        program that activates the drivers of both robots, sends GOALS goals to each with the random
                 seed SEED, uses the grippers, and deactivates them: PROGRAM GOALS SEED
  WORD...        only sessions with one of these words in their name

The drivers' sources are NIST's; they are built outside this tree. Exit code 1 if a session ends with an error,
4 if no network namespace is permitted."""

import argparse
import importlib.util
import json
import pathlib
import subprocess
import sys
import threading
import time
from importlib.machinery import SourceFileLoader

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(HERE.parent / "integration" / "kitting")]
sys.dont_write_bytecode = True

import running_cell  # noqa: E402
import tap  # noqa: E402

_spec = importlib.util.spec_from_loader("lab", SourceFileLoader("lab", str(ROOT / "server" / "lab")))
lab = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(lab)

FANUC, MOTOMAN = lab.ADDRESSES["Fanuc"], lab.ADDRESSES["Motoman"]
PLACES = {
    "motion.fanuc": (FANUC, 11000),
    "state.fanuc": (FANUC, 11002),
    "gripper.fanuc": (FANUC, 12123),
    "motion.motoman": (MOTOMAN, 50240),
    "state.motoman": (MOTOMAN, 50241),
    "gripper.motoman": (MOTOMAN, 50242),
}
SCENE = "aprs_2024"
POINT_BYTES, SEQUENCE = 152, slice(20, 24)  # of the Motoman's points
# A program that does not end after this time hangs.
HANGS_S = 120
# Positions on the way of the second goal of SEED [rad].
SEED = 11
ON_THE_WAY = {"fanuc": "joint-position:fanuc:1>0.1", "motoman": "joint-position:motoman:1<-0.15"}
# The Motoman's drivers rest between goals.
REST_S = 0.4


class Session:
    def __init__(self, options, folder):
        self.program, self.folder = options.program, folder
        folder.mkdir(parents=True, exist_ok=True)
        self.daemon = running_cell.Daemon(running_cell.BINARIES, "--scene", SCENE, "--no-web")
        ports = {name: port for name, port in self.daemon.ports.items() if name in PLACES}
        self.tap = tap.Tap(ports, at=PLACES)
        self.output = []

    def cell(self, *words):
        """A command of `aprsim`, which is recorded."""
        self.tap.note_action(" ".join(words))
        self._aprsim(*words)

    def _aprsim(self, *words):
        program = f"{running_cell.BINARIES}/aprsim"
        return subprocess.run(
            [program, "--ports-file", self.daemon.ports_file, *words],
            check=True,
            capture_output=True,
            timeout=60,
        ).stdout

    def await_end_of_faults(self):
        def ended():
            listed = json.loads(self._aprsim("fault", "list", "--json"))
            return all(fault["state"] != "active" for fault in listed["faults"])

        running_cell.eventually(ended, 20, "the faults end")

    def drive(self, goals, seed, hangs_s=HANGS_S):
        """Runs the program to its end; None if it hangs."""
        try:
            done = subprocess.run(
                [self.program, str(goals), str(seed)], capture_output=True, text=True, timeout=hangs_s
            )
        except subprocess.TimeoutExpired as hung:
            self.output.append((hung.stdout or b"").decode() + f"hangs after {hangs_s} s\n")
            return None
        self.output.append(done.stdout + done.stderr)
        return done.returncode

    def end(self, name):
        (self.folder / "end.json").write_text(
            json.dumps({"session": name, "options": ["--scene", SCENE]}), encoding="utf-8"
        )
        tap.save(self.tap, self.folder / "exchange.jsonl")
        (self.folder / "output.txt").write_text("".join(self.output), encoding="utf-8")
        (self.folder / "daemon.log").write_text(self.daemon.log_text(), encoding="utf-8")
        self.tap.close()
        self.daemon.stop()
        self.daemon.close()


def goals_of_both_robots(session):
    """Ten goals of each robot, the grippers closed and opened."""
    session.drive(10, SEED)


def with_faults(*words, robots=("fanuc", "motoman")):
    """A fault of each robot in mid-motion, and the drivers started anew afterwards."""

    def run(session):
        for robot in robots:
            session.cell("fault", "inject", words[0], robot, "--when", ON_THE_WAY[robot], *words[1:])
        session.drive(3, SEED)
        session.await_end_of_faults()
        # Errors of the Fanuc stay until somebody initializes it; the Motoman's drivers clear theirs.
        session.cell("crcl", "init", "--robot", "fanuc")
        session.drive(2, SEED + 20)

    return run


def silent_states(session):
    """The state ports send nothing for a second in mid-motion; the drivers wait."""
    for robot, when in ON_THE_WAY.items():
        session.cell("fault", "inject", "simple-message-silent", robot, "--when", when, "--for", "1")
    session.drive(3, SEED)


def dropped_connections(session):
    """All connections are dropped while the Motoman is at rest after two goals. The drivers do not survive it; they are
    started anew."""
    dropping = threading.Thread(target=drop_at_rest, args=(session, 2))
    dropping.start()
    session.drive(4, SEED, hangs_s=20)
    dropping.join()
    session.drive(2, SEED + 20)


def drop_at_rest(session, goals):
    """Drops the connections when the Motoman has got this many goals and no more points come."""
    deadline = time.monotonic() + HANGS_S
    while time.monotonic() < deadline:
        sent = [chunk for chunk in list(session.tap.chunks) if chunk.from_client and chunk.data
                and session.tap.target(chunk) == "motion.motoman"]  # fmt: skip
        begun = sum(len(chunk.data) == POINT_BYTES and chunk.data[SEQUENCE] == bytes(4) for chunk in sent)
        if begun >= goals and time.monotonic() - sent[-1].at > REST_S:
            break
        time.sleep(0.02)
    for robot in ("fanuc", "motoman"):
        session.cell("fault", "inject", "simple-message-drop", robot)


SESSIONS = {
    "goals of both robots": goals_of_both_robots,
    "protective stops": with_faults("protective-stop"),
    "emergency stops": with_faults("robot-emergency-stop", "--for", "2"),
    "silent states": silent_states,
    "dropped connections": dropped_connections,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", type=pathlib.Path, required=True)
    parser.add_argument("program")
    parser.add_argument("words", nargs="*")
    options = parser.parse_args()
    try:
        lab.enter_namespace(as_user=False)
        lab.add_addresses()
    except OSError as error:
        print(f"may not create a network namespace: {error.strerror}", file=sys.stderr)
        return lab.NOT_PERMITTED
    for name, run in SESSIONS.items():
        if options.words and not any(word in name for word in options.words):
            continue
        session = Session(options, options.keep / name.replace(" ", "_"))
        try:
            run(session)
        finally:
            session.end(name)
        print(f"{name}:\n{''.join(session.output)}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
