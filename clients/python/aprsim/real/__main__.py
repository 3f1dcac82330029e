"""Puts real robots, belts and cameras beside the simulated ones.

mirror  the cell's robot moves as the real one, whose states are read by CRCL or Simple Message
belt    the cell's belt does what a real PLC commands, whose registers are read by Modbus/TCP
camera  bodies of the cell are moved to where the lines of a real camera have them
proxy   controllers connect here and command the real robot; the cell's robot moves as it does
shadow  controllers connect here; real and simulated robot get the same commands and are compared
run     all devices of a file, in one process

Nothing that commands is sent to a real device without --allow-commands. Ctrl-C ends the program.
exit codes: 0 ended; 1 real and simulated ones have parted (shadow); 2 a wrong argument; 3 no cell"""

from __future__ import annotations

import argparse
import dataclasses
import signal
import sys
import threading
import time
from contextlib import ExitStack
from typing import Any, Sequence

from .. import arguments
from ..cell import Cell
from ..errors import AprsimError, BadArgument, Unreachable
from .base.devices import address
from .building import Builder
from .programs import run_all
from .settings import (
    ADDRESSES,
    LIMITS,
    LISTENS,
    SIMPLE_MESSAGE_ONLY,
    BeltSettings,
    CameraSettings,
    Common,
    RobotSettings,
)
from .settings_file import read_file
from .simple_message.messages import CONTROLLERS


def main(words: Sequence[str] | None = None) -> int:
    """The program. Returns its exit code."""
    options = _command_line().parse_args(words)
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    try:
        settings = read_file(options.file) if options.program == "run" else [_settings(options)]
        with ExitStack() as opened:
            cell = opened.enter_context(Cell.connect(options.ports_file, token_file=options.token_file))
            builder = Builder(cell, opened, _report)
            alarms = run_all([builder.build(one) for one in settings], ended, _report)
        return 1 if alarms else 0
    except Unreachable as error:
        print(f"aprsim.real: {error}", file=sys.stderr)
        return 3
    except AprsimError as error:
        print(f"aprsim.real: {error}", file=sys.stderr)
        return 2


def _report(text: str) -> None:
    print(f"{time.strftime('%H:%M:%S')} {text}", flush=True)


def _settings(options: argparse.Namespace) -> Common:
    """The settings of one device, checked."""
    kind: type[Common] = {"belt": BeltSettings, "camera": CameraSettings}.get(options.program, RobotSettings)
    values: dict[str, Any] = {"source": options.program}
    if options.program in ("belt", "camera"):
        shadows = options.program == "belt" and options.shadow
        values["source"] = "shadow" if shadows else "proxy" if options.listen is not None else "mirror"
    for field in dataclasses.fields(kind):
        value = getattr(options, field.name, None)
        if field.name == "source" or value is None:
            continue
        if field.name in SIMPLE_MESSAGE_ONLY and (options.wire or "crcl") == "crcl":
            raise BadArgument(f"{field.name}: '{value}', which is for --wire {' and '.join(CONTROLLERS)}")
        if field.name in LIMITS:
            low, high, unit = LIMITS[field.name]
            value = arguments.number(field.name, value, unit, low=low, high=high)
        if field.name in LISTENS or field.name in ADDRESSES:
            value = _address(field.name, value)
        values[field.name] = value
    return kind(**values)


def _address(name: str, text: str) -> tuple[str, int]:
    try:
        return address(text, free=name in LISTENS)
    except BadArgument:
        raise BadArgument(f"{name}: '{text}', where HOST:PORT is expected") from None


def _command_line() -> argparse.ArgumentParser:
    text, _, details = (__doc__ or "").partition("\n\n")
    parser = argparse.ArgumentParser(
        prog="python3 -m aprsim.real",
        description=text,
        epilog=details,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    names = ("mirror", "belt", "camera", "proxy", "shadow", "run")
    programs = parser.add_subparsers(required=True, metavar="|".join(names), dest="program")
    for name in names:
        one = programs.add_parser(name)
        one.add_argument("--ports-file", help="of the cell")
        one.add_argument("--token-file", help="of the cell")
        if name == "run":
            one.add_argument("file", help="devices, as docs/real.md describes")
            continue
        if name != "belt":
            one.add_argument("name", metavar="robot", help="of the cell")
        one.add_argument("address", metavar="HOST:PORT", help="the real one")
        one.add_argument("--patience-s", type=float, help="longest wait for an answer (1)")
        _add_device(one, name)
    return parser


def _add_device(one: argparse.ArgumentParser, name: str) -> None:

    def address_of(option: str, text: str) -> None:
        one.add_argument(option, metavar="HOST:PORT", help=text)

    if name != "camera":
        one.add_argument("--rate", type=float, help="questions a second (50)")
    if name in ("mirror", "proxy", "shadow"):
        one.add_argument("--wire", choices=("crcl", *CONTROLLERS), help="of the real robot (crcl)")
        address_of("--gripper", "the real gripper's port (Simple Message)")
    if name in ("proxy", "shadow"):
        address_of("--motion", "the real motion port (Simple Message; the usual one)")
        address_of("--listen-state", "for controllers that read states")
        address_of("--listen-gripper", "for controllers of the gripper")
    if name == "belt":
        one.add_argument("--forward", type=int, choices=(0, 1), help="direction register (1)")
        one.add_argument("--count-m-s", type=float, help="unit of the registers (1e-5)")
        one.add_argument("--shadow", action="store_true", help="send writes to both belts and compare them")
    if name == "camera":
        address_of("--pictures", "the real camera's HTTP port")
        address_of("--listen-pictures", "for clients of pictures")
    if name != "mirror":
        address_of("--listen", "for controllers")
    if name in ("belt", "proxy", "shadow"):
        one.add_argument("--allow-commands", action="store_true", help="pass commands to the real one")
    if name in ("belt", "shadow"):
        one.add_argument("--most-mm", type=float, help="between the places (1.5)")
        one.add_argument("--most-ms", type=float, help="between their times (40)")


if __name__ == "__main__":
    sys.exit(main())
