"""Estimates a scene's parameters from recordings of a real cell, or compares a scene with a recording.

exit codes: 0 done; 1 a difference is beyond its limit; 2 a wrong argument or file"""

from __future__ import annotations

import argparse
import math
import sys
from pathlib import Path
from typing import Sequence

from ..errors import AprsimError, BadArgument

LIMITS = ("position_mm", "angle_deg", "time_s", "speed_m_s", "force_n")
"""Names of the limits of a comparison."""


def main(arguments: Sequence[str] | None = None) -> int:
    """The program. Returns its exit code."""
    options = _command_line().parse_args(arguments)
    try:
        code: int = options.run(options)
        return code
    except AprsimError as error:
        print(f"aprsim {options.program}: {error}", file=sys.stderr)
    except ImportError as error:
        packages = "Debian: python3-scipy, python3-yaml"
        print(f"aprsim {options.program}: needs {error.name}, which is not installed ({packages})", file=sys.stderr)
    return 2


def _command_line() -> argparse.ArgumentParser:
    text, _, details = (__doc__ or "").partition("\n\n")
    parser = argparse.ArgumentParser(
        prog="python3 -m aprsim.calibration",
        description=text,
        epilog=details,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(required=True, metavar="calibrate|compare", dest="program")
    fit = commands.add_parser("calibrate", help="estimate parameters and write a scene")
    fit.set_defaults(run=_calibrate)
    fit.add_argument("captures", nargs="+", type=Path, help="journals, force logs (CSV), camera lines")
    fit.add_argument("--out", type=Path, help="scene to write, whose base is the scene")
    against = commands.add_parser("compare", help="run the commands of a recording in a scene")
    against.set_defaults(run=_compare)
    against.add_argument("capture", type=Path, help="journal, force log (CSV) or camera lines")
    against.add_argument(
        "--limit", action="append", default=[], metavar="NAME=NUMBER",
        help="largest root mean square: " + ", ".join(LIMITS),
    )
    for one in (fit, against):
        one.add_argument("--scene", required=True, help="scene of the cell: a name or a file")
        one.add_argument("--robot", help="robot of force logs and camera lines (default: the scene's first)")
        one.add_argument("--json", action="store_true", help="print one JSON object")
    return parser


def _calibrate(options: argparse.Namespace) -> int:
    from .calibrating import calibrate

    result = calibrate(options.captures, options.scene, options.robot)
    if options.out is not None:
        try:
            options.out.write_text(result.overlay(), encoding="utf-8")
        except OSError as error:
            raise BadArgument(f"out: {options.out}: {error.strerror}") from error
    print(result.as_json() if options.json else result.report(), end="\n" if options.json else "")
    return 0


def _compare(options: argparse.Namespace) -> int:
    from .comparing import compare

    result = compare(options.capture, options.scene, options.robot, _limits(options.limit))
    print(result.as_json() if options.json else result.report(), end="\n" if options.json else "")
    return 1 if result.beyond() else 0


def _limits(texts: Sequence[str]) -> dict[str, float]:
    out = {}
    for text in texts:
        name, _, number = text.partition("=")
        try:
            value = float(number)
        except ValueError:
            value = math.nan
        if name not in LIMITS or not value >= 0:
            raise BadArgument(f"limit: found '{text}', expected NAME=NUMBER with a name of {', '.join(LIMITS)}")
        out[name] = value
    return out


if __name__ == "__main__":
    sys.exit(main())
