"""Common parts of the programs in this folder: connections to robots and cameras, and sequences of
jobs."""

from __future__ import annotations

import argparse
import contextlib
import json
import signal
import sys
import threading
from typing import Callable, Mapping, Sequence

from blind import BlindCamera, BlindRobot
from calibration import Correction
from cell import Cell, CellError, Robot
from clock import Clock, PollClock
from crcl_robot import CrclRobot, RobotLost
from ros_robot import ROBOTS, RosRobot
from vision import Camera, DetectionError

DONE, INCOMPLETE, USAGE, NO_CONNECTION, INTERRUPTED = 0, 1, 2, 3, 130
_FEED_S = 20.0  # for the first frame of a camera


def host_of(text: str) -> str:
    """The host of an argument. An IPv6 address may have brackets (RFC 3986, 3.2.2)."""
    inside = text[1:-1] if text.startswith("[") and text.endswith("]") else text
    if not inside or "[" in inside or "]" in inside:
        raise argparse.ArgumentTypeError(f"'{text}', where a host name or an address is expected")
    return inside


Wires = dict[str, tuple[CrclRobot | RosRobot, Camera]]


CRCL, SIMPLE_MESSAGE = "crcl", "simple-message"


def wires_of(robot: str, given: str) -> str:
    """The wires of a robot by the argument of --wires: common to all, or ROBOT=WIRES of some. Raises
    CellError."""
    found = CRCL
    for part in given.split(","):
        name, equals, wires = part.rpartition("=")
        if wires not in (CRCL, SIMPLE_MESSAGE):
            raise CellError(f"--wires: '{wires}': {CRCL} or {SIMPLE_MESSAGE} is expected")
        if not equals or name == robot:
            found = wires
    return found


def connection_to(
    robot: Robot, options: argparse.Namespace, clock: Clock
) -> CrclRobot | RosRobot:
    # In virtual time an answer may wait for other clients.
    answer_s = 3600.0 if clock.counts_polls else 5.0
    limit_s = options.move_limit
    if wires_of(robot.name, options.wires) == SIMPLE_MESSAGE:
        assert robot.ros is not None
        return ROBOTS[robot.ros.controller](
            robot, robot.ros, clock=clock, answer_s=answer_s, move_limit_s=limit_s
        )
    return (BlindRobot if options.blind else CrclRobot)(
        robot.name,
        robot.host,
        robot.crcl_port,
        clock=clock,
        answer_s=answer_s,
        move_limit_s=limit_s,
        curtain=robot.curtain,
    )


def open_wires(
    cell: Cell,
    robots: Sequence[Robot],
    options: argparse.Namespace,
    clock: Clock,
    corrections: Mapping[str, Correction],
) -> Wires:
    wires: Wires = {}
    for robot in robots:
        crcl = connection_to(robot, options, clock)
        correction = corrections.get(robot.name, Correction())
        camera = (BlindCamera if options.blind else Camera)(
            robot.host,
            robot.vision_port,
            robot.frame,
            correction,
            clock=clock,
            polls_per_line=options.polls_per_line,
        )
        camera.start()
        wires[robot.name] = (crcl, camera)
    return wires


def close_wires(wires: Wires) -> None:
    for crcl, camera in wires.values():
        crcl.close()
        camera.close()


def interrupted_by_signals(wires: Wires) -> threading.Event:
    """An event that Ctrl-C and SIGTERM set; they also end waits for robots."""
    interrupted = threading.Event()

    def on_signal(*_: object) -> None:
        interrupted.set()
        for crcl, _camera in wires.values():
            crcl.interrupt()

    signal.signal(signal.SIGINT, on_signal)
    signal.signal(signal.SIGTERM, on_signal)
    return interrupted


def run_jobs(
    wires: Wires, interrupted: threading.Event, job: Callable[[int], tuple[int, bool]]
) -> int:
    """Run the jobs that standard input begins with {"begin": SEED}. `job` returns the exit code, and
    whether another job may follow; "ready" is reported then."""
    # All connections are open before the cell is reset, so that the first job begins like the others. A missing
    # connection is reported by the job.
    for crcl, camera in wires.values():
        with contextlib.suppress(RobotLost):
            crcl.open()
        with contextlib.suppress(DetectionError):
            camera.await_feed(_FEED_S)
    code, more = DONE, True
    while more and not interrupted.is_set():
        print(json.dumps({"event": "ready"}), flush=True)
        seed = _next_seed()
        if seed is None:
            break
        clock = next(iter(wires.values()))[0].clock
        if clock.counts_polls:
            clock = PollClock(clock.poll_s)
        for crcl, camera in wires.values():
            crcl.begin(clock, lambda event, text: None)
            camera.begin(clock)
        code, more = job(seed)
    return code


def _next_seed() -> int | None:
    for line in iter(sys.stdin.readline, ""):
        try:
            message = json.loads(line)
        except ValueError:
            continue
        if isinstance(message, dict) and isinstance(message.get("begin"), int):
            return int(message["begin"])
    return None
