"""Puts a real robot or belt beside the simulated one.

mirror  the cell's robot moves as the real one, which is asked for its statuses by CRCL
belt    the cell's belt does what a real PLC commands, whose registers are read by Modbus/TCP
proxy   controllers connect here and command the real robot; the cell's robot moves as it does
shadow  controllers connect here; real and simulated robot get the same commands and are compared

Nothing that commands is sent to a real robot without --allow-commands. Ctrl-C ends the program.
exit codes: 0 ended; 1 the robots have parted (shadow); 2 a wrong argument; 3 no cell"""

from __future__ import annotations

import argparse
import signal
import sys
import threading
import time
from contextlib import ExitStack
from typing import Sequence

from .. import arguments
from ..cell import Cell
from ..errors import AprsimError, BadArgument, Unreachable
from .belt_mirror import BeltMirror
from .deviation import Comparison
from .devices import address
from .relay import Relay
from .robot_mirror import RobotMirror
from .shadow import Shadow


def main(words: Sequence[str] | None = None) -> int:
    """The program. Returns its exit code."""
    options = _command_line().parse_args(words)
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    try:
        options.device = address(options.device)
        options.period_s = 1 / arguments.number("rate", options.rate, "Hz", low=1, high=250)
        code = _run(options, ended)
    except Unreachable as error:
        print(f"aprsim.real: {error}", file=sys.stderr)
        return 3
    except AprsimError as error:
        print(f"aprsim.real: {error}", file=sys.stderr)
        return 2
    return code


def _run(options: argparse.Namespace, ended: threading.Event) -> int:
    with ExitStack() as opened:
        options.cell = opened.enter_context(Cell.connect(options.ports_file, token_file=options.token_file))
        code: int = options.run(options, opened, ended)
    return code


def _command_line() -> argparse.ArgumentParser:
    text, _, details = (__doc__ or "").partition("\n\n")
    parser = argparse.ArgumentParser(
        prog="python3 -m aprsim.real",
        description=text,
        epilog=details,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    programs = parser.add_subparsers(required=True, metavar="mirror|belt|proxy|shadow")
    for name, run in (("mirror", _mirror), ("belt", _belt), ("proxy", _proxy), ("shadow", _shadow)):
        one = programs.add_parser(name)
        one.set_defaults(run=run)
        if name != "belt":
            one.add_argument("robot", help="of the cell")
        one.add_argument("device", metavar="HOST:PORT", help="the real one")
        one.add_argument("--rate", type=float, default=50, help="questions a second (50)")
        one.add_argument("--patience-s", type=float, default=1.0, help="longest wait for an answer (1)")
        one.add_argument("--ports-file", help="of the cell")
        one.add_argument("--token-file", help="of the cell")
        if name == "belt":
            one.add_argument("--forward", type=int, choices=(0, 1), default=1, help="direction register (1)")
            one.add_argument("--count-m-s", type=float, default=1e-5, help="unit of the speed register (1e-5)")
        if name in ("proxy", "shadow"):
            one.add_argument("--listen", default="127.0.0.1:0", metavar="HOST:PORT", help="for controllers")
            one.add_argument("--allow-commands", action="store_true", help="pass commands to the real robot")
        if name == "shadow":
            one.add_argument("--most-mm", type=float, default=1.5, help="between the tools (1.5)")
            one.add_argument("--most-ms", type=float, default=40, help="between their times (40)")
    return parser


def _report(text: str) -> None:
    print(f"{time.strftime('%H:%M:%S')} {text}", flush=True)


def _mirror(options: argparse.Namespace, _opened: ExitStack, ended: threading.Event) -> int:
    _robot_mirror(options).run(ended)
    return 0


def _robot_mirror(options: argparse.Namespace) -> RobotMirror:
    return RobotMirror(
        options.cell, options.robot, *options.device, period_s=options.period_s, patience_s=options.patience_s,
        report=_report,
    )


def _belt(options: argparse.Namespace, _opened: ExitStack, ended: threading.Event) -> int:
    BeltMirror(
        options.cell, *options.device, period_s=options.period_s, patience_s=options.patience_s, report=_report,
        forward=options.forward, count_m_s=arguments.number("count_m_s", options.count_m_s, "m/s", above=0),
    ).run(ended)
    return 0


def _relay(options: argparse.Namespace, opened: ExitStack, copy: tuple[str, int] | None) -> None:
    listen = options.listen
    host, colon, port = listen.rpartition(":")
    if not colon or not port.isdecimal() or int(port) > 65535:
        raise BadArgument(f"listen: '{listen}', where HOST:PORT is expected")
    relay = opened.enter_context(
        Relay(
            (host, int(port)), options.device, allow_commands=options.allow_commands, copy=copy, report=_report
        )
    )
    _report(f"controllers: {host}:{relay.port}")


def _proxy(options: argparse.Namespace, opened: ExitStack, ended: threading.Event) -> int:
    mirror = _robot_mirror(options)
    _relay(options, opened, None)
    mirror.run(ended)
    return 0


def _shadow(options: argparse.Namespace, opened: ExitStack, ended: threading.Event) -> int:
    endpoints = options.cell.endpoints
    simulated = (endpoints.host, endpoints.crcl_port(options.robot))
    comparison = Comparison(
        most_distance_m=1e-3 * arguments.number("most_mm", options.most_mm, "mm", above=0),
        most_delay_s=1e-3 * arguments.number("most_ms", options.most_ms, "ms", above=0),
    )
    shadow = Shadow(
        options.device, simulated, comparison, period_s=options.period_s, patience_s=options.patience_s,
        report=_report,
    )
    _relay(options, opened, simulated)
    shadow.run(ended)
    return 1 if shadow.alarms else 0


if __name__ == "__main__":
    sys.exit(main())
