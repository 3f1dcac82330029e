"""Finds trays and gears in the pictures of a cell's cameras, and publishes them as vision lines."""

from __future__ import annotations

import argparse
import json
import signal
import sys
import time
from pathlib import Path
from typing import Any

from .camera_map import CameraMap, from_description
from .errors import VisionError
from .mjpeg import MjpegReader
from .prior import Prior, read_prior
from .publisher import LinePublisher, vision_line
from .sight import Sight

DONE, USAGE, NO_CAMERA, INTERRUPTED = 0, 2, 3, 130
_PATH = "/mjpg/video.mjpg"
_FIRST_PICTURE_S = 30.0
_REPORT_S = 5.0  # between reports of one trouble


class Feed:
    """A camera with its stream, its vision, and the port of its lines."""

    def __init__(self, name: str, url: str, sight: Sight, publisher: LinePublisher | None) -> None:
        self.name, self.sight, self.publisher = name, sight, publisher
        self.reader = MjpegReader(url)
        self.number = 0
        self._reported_at = time.monotonic()  # a first picture takes its time

    def look(self, timeout_s: float) -> bytes | None:
        """The line of the latest picture, once."""
        frame = self.reader.latest(self.number, timeout_s)
        if frame is None:
            return None
        self.number = frame.number
        return vision_line(self.sight.objects(frame.jpeg))

    def report(self, text: str) -> None:
        if time.monotonic() - self._reported_at >= _REPORT_S:
            self._reported_at = time.monotonic()
            print(f"vision: {text}", file=sys.stderr, flush=True)

    def close(self) -> None:
        self.reader.close()
        if self.publisher is not None:
            self.publisher.close()


def main() -> int:
    options = command_line().parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    feeds: list[Feed] = []
    try:
        open_feeds(options, feeds)
        return look_once(feeds) if options.once else serve(feeds)
    except VisionError as error:
        print(f"vision: {error}", file=sys.stderr)
        return USAGE
    except KeyboardInterrupt:
        return INTERRUPTED
    finally:
        for feed in feeds:
            feed.close()


def open_feeds(options: argparse.Namespace, feeds: list[Feed]) -> None:
    """Open a feed for each camera of the cell file. Raises VisionError."""
    prior = read_prior(options.cell)
    ports = read_ports(options.ports_file) if options.ports_file else {}
    given = pairs(options.camera, "--camera", prior)
    maps = maps_of(prior, options)
    for name, camera in prior.cameras.items():
        port = ports.get(f"camera.{name}", camera.camera_port)
        url = given.get(name, f"http://{options.host}:{port}{_PATH}")
        publisher = None
        if not options.once:
            publisher = LinePublisher(options.bind, 0 if options.any_port else camera.port)
            ports[f"vision.{camera.robot}"] = publisher.port
            print(f"vision: {name}: {url}, lines of {camera.robot} on port {publisher.port}", flush=True)
        feeds.append(Feed(name, url, Sight(prior, camera, maps[name]), publisher))
    if options.write_ports:
        try:
            # A reader never sees half of it.
            draft = options.write_ports.with_name(options.write_ports.name + ".part")
            draft.write_text(json.dumps(ports, indent=2) + "\n", encoding="utf-8")
            draft.replace(options.write_ports)
        except OSError as error:
            raise VisionError(f"--write-ports: {error}") from error


def look_once(feeds: list[Feed]) -> int:
    for feed in feeds:
        try:
            line = feed.look(_FIRST_PICTURE_S)
        except VisionError as error:
            print(f"vision: {error}", file=sys.stderr)
            return NO_CAMERA
        if line is None:
            print(f"vision: {feed.reader.trouble}", file=sys.stderr)
            return NO_CAMERA
        print(feed.name, line.decode().strip(), flush=True)
    return DONE


def serve(feeds: list[Feed]) -> int:
    while True:
        for feed in feeds:
            assert feed.publisher is not None
            try:
                line = feed.look(0.05)
            except VisionError as error:
                feed.report(str(error))
                continue
            if line is not None:
                feed.publisher.publish(line)
            elif feed.number == 0:
                feed.report(feed.reader.trouble)


def maps_of(prior: Prior, options: argparse.Namespace) -> dict[str, CameraMap]:
    if options.maps == "cell":
        return maps_of_cell(prior, options)
    missing = [name for name, camera in prior.cameras.items() if camera.map is None]
    if missing:
        raise VisionError(f"the cell file has no lens of {', '.join(missing)}; --maps cell asks the cell")
    return {name: camera.map for name, camera in prior.cameras.items() if camera.map is not None}


def maps_of_cell(prior: Prior, options: argparse.Namespace) -> dict[str, CameraMap]:
    try:
        from aprsim import AprsimError, Cell
    except ImportError as error:
        raise VisionError(f"--maps cell: the Python package of the cell: {error}") from error
    if not hasattr(Cell, "camera"):
        raise VisionError("--maps cell: this version of the Python package knows no cameras")
    try:
        with Cell.connect(options.ports_file) as cell:
            return {name: from_description(cell.camera(name)) for name in prior.cameras}
    except AprsimError as error:
        raise VisionError(f"--maps cell: {error}") from error


def read_ports(path: Path) -> dict[str, Any]:
    try:
        ports = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise VisionError(f"--ports-file: {path}: {error}") from error
    if not isinstance(ports, dict):
        raise VisionError(f"--ports-file: {path}: an object of names and ports is expected")
    return ports


def pairs(given: list[str], option: str, prior: Prior) -> dict[str, str]:
    found = {}
    for text in given:
        name, equals, value = text.partition("=")
        if name not in prior.cameras or not equals:
            known = ", ".join(prior.cameras)
            raise VisionError(f"{option}: '{text}': NAME=URL with one of {known} is expected")
        found[name] = value
    return found


def command_line() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python3 -m clients.vision", description=__doc__)
    parser.add_argument(
        "--cell", default="aprs_2025", help="aprs_2024, aprs_2025, or a TOML file such as cells/aprs_2025.toml"
    )
    parser.add_argument("--host", default="127.0.0.1", help="host of the cell's cameras")
    parser.add_argument("--ports-file", type=Path, help="ports file written by the daemon")
    parser.add_argument(
        "--camera",
        action="append",
        default=[],
        metavar="NAME=URL",
        help="address of a camera's MJPEG stream, as in fanuc_table=http://192.168.1.104/mjpg/video.mjpg; repeatable",
    )
    parser.add_argument(
        "--maps",
        choices=["file", "cell"],
        default="file",
        help="lenses and places of the cameras: of the cell file, or asked from the cell by gRPC",
    )
    parser.add_argument("--bind", default="127.0.0.1", help="address on which lines are served")
    parser.add_argument("--any-port", action="store_true", help="serve the lines on free ports")
    parser.add_argument(
        "--write-ports",
        type=Path,
        metavar="FILE",
        help="write the ports file with the ports of these lines, for the kitting controller",
    )
    parser.add_argument("--once", action="store_true", help="print one line a camera and exit")
    return parser


if __name__ == "__main__":
    sys.exit(main())
