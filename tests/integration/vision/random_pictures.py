"""Pictures of random layouts in the laboratory of 2025, with the true trays and gears. As a program: the
detection of clients/vision on them; prints a line a layout and a summary.

    random_pictures.py [--count 20] [--seed 1] [--gap-mm 4] [--margin-mm 0] [--json FILE]
"""

import argparse
import json
import math
import os
import pathlib
import sys
import unittest
from dataclasses import dataclass

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "clients" / "python"), str(HERE.parent / "kitting")]
os.environ.setdefault("APRSIM_BIN_DIR", str(ROOT / "build" / "release" / "bin"))

from aprsim import Cell, Daemon  # noqa: E402
from random_layouts import GAP_MM, Layout  # noqa: E402

PATIENCE = float(os.environ.get("APRSIM_PATIENCE", "1"))  # factor on deadlines
SETTLED_STEPS = 1000
FRESH = 4  # pictures of a new stream, after which none is older than the stream
SEATED_M = 3e-3


@dataclass(frozen=True)
class TrueTray:
    """A tray that lies in a robot's view. Millimetres and radians in the world."""

    name: str
    type: str
    label: int
    robot: str
    x_mm: float
    y_mm: float
    yaw: float
    gears: dict  # slot: type of the seated gear, or None

    def away_mm(self, x_mm, y_mm):
        return math.dist((self.x_mm, self.y_mm), (x_mm, y_mm))

    def turn_deg(self, yaw):
        return abs(math.degrees(math.remainder(yaw - self.yaw, math.tau)))


class PicturedCell:
    """A paused cell of the laboratory that shows one layout after the other."""

    def __init__(self):
        self.daemon = Daemon("--no-web", scene="aprs_2025", speed="stepped", start_s=60 * PATIENCE)
        try:
            self.cell = Cell.connect(self.daemon.ports_file)
        except BaseException:
            self.daemon.close()
            raise
        self.ports = json.loads(self.daemon.ports_file.read_text(encoding="utf-8"))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self.cell.close()
        self.daemon.close()

    def show(self, layout=None):
        """The cell of a layout (None: the recorded one) after its bodies have settled. Its true trays."""
        if layout is None:
            self.cell.reset(scene="aprs_2025")
        else:
            self.cell.reset(scene_text=layout.scene())
        self.cell.step_without_snapshot(SETTLED_STEPS)
        return self._true_trays(layout or Layout(0))

    def stream(self, camera):
        """The address of a camera's pictures."""
        return f"http://127.0.0.1:{self.ports[f'camera.{camera}']}/mjpg/video.mjpg"

    def _true_trays(self, layout):
        bodies = self.cell.snapshot(["bodies"]).bodies.values()
        types = layout.cell.trays
        gears = [body for body in bodies if body.type in layout.cell.gears]
        found = []
        for body in (body for body in bodies if body.type in types):
            x, y = (1e3 * body.position_m[:2]).tolist()
            robot = next((r.name for r in layout.cell.robots.values() if _within(r.view_mm, x, y)), None)
            if robot is None:
                continue
            seated = {}
            for slot in types[body.type].slots:
                place = (body.pose @ [slot.xy_mm[0] / 1e3, slot.xy_mm[1] / 1e3, 0, 1])[:3]
                near = [gear.type for gear in gears if math.dist(gear.position_m, place) < SEATED_M]
                seated[slot.name] = near[0] if near else None
            yaw = math.atan2(body.pose[1, 0], body.pose[0, 0])
            label = int(body.name[-2:])
            found.append(TrueTray(body.name, body.type, label, robot, x, y, yaw, seated))
        return found


class Score:
    """Counts and errors of a detection over many trays."""

    def __init__(self):
        self.trays = self.found = self.slots = self.right_slots = self.extra = 0
        self.away_mm, self.turn_deg = [], []
        self.troubles = []

    def missed(self, text):
        self.troubles.append(text)

    def summary(self):
        return {
            "trays": self.trays,
            "trays_found_with_type_and_label": self.found,
            "trays_that_are_none": self.extra,
            "slots": self.slots,
            "slots_right": self.right_slots,
            "position_mm": _spread(self.away_mm),
            "yaw_deg": _spread(self.turn_deg),
        }


def _within(area, x, y):
    (x0, y0), (x1, y1) = area
    return x0 <= x <= x1 and y0 <= y <= y1


def _spread(values):
    """Median, 99th percentile and greatest."""
    if not values:
        return None
    ordered = sorted(values)
    return [round(ordered[min(len(ordered) - 1, int(q * len(ordered)))], 3) for q in (0.5, 0.99, 1)]


class OwnVision:
    """The detection of clients/vision on the MJPEG streams of a cell."""

    def __init__(self, shown):
        import cv2
        from clients.vision.gear_finder import Content, GearFinder
        from clients.vision.mjpeg import MjpegReader
        from clients.vision.prior import read_prior
        from clients.vision.tray_finder import TrayFinder

        self.cv2, self.reader, self.content, self.shown = cv2, MjpegReader, Content, shown
        self.prior = read_prior("aprs_2025")
        self.finders = {
            name: (TrayFinder(self.prior, camera.map), GearFinder(self.prior, camera.map))
            for name, camera in self.prior.cameras.items()
        }

    def compare(self, truth, score, text):
        """Adds what is found in the present pictures to a score."""
        for name, camera in self.prior.cameras.items():
            picture = self._picture(name)
            trays, gears = self.finders[name]
            seen = [t for t in trays.find(picture) if camera.in_view((t.pose.x_mm, t.pose.y_mm))]
            slots = gears.find(picture, seen).slots
            expected = [tray for tray in truth if tray.robot == camera.robot]
            score.extra += max(0, len(seen) - len(expected))
            for tray in expected:
                self._compare_tray(tray, seen, slots, score, f"{text}, {name}, {tray.name}")

    def _picture(self, name):
        import numpy as np

        reader = self.reader(self.shown.stream(name))
        try:
            frame = reader.latest(FRESH - 1, 120 * PATIENCE)
            if frame is None:
                raise AssertionError(reader.trouble)
        finally:
            reader.close()
        return self.cv2.imdecode(np.frombuffer(frame.jpeg, np.uint8), self.cv2.IMREAD_COLOR)

    def _compare_tray(self, tray, seen, slots, score, text):
        score.trays += 1
        score.slots += len(tray.gears)
        same = [t for t in seen if (t.type.name, t.label) == (tray.type, tray.label)]
        if not same:
            score.missed(f"{text}: not found")
            return
        own = min(same, key=lambda t: tray.away_mm(t.pose.x_mm, t.pose.y_mm))
        score.found += 1
        score.away_mm.append(tray.away_mm(own.pose.x_mm, own.pose.y_mm))
        score.turn_deg.append(tray.turn_deg(own.pose.yaw))
        for view in (view for view in slots if view.tray is own):
            gear = tray.gears[view.slot.name]
            right = view.gear.type.name == gear if view.gear and gear else view.content is self.content.EMPTY
            if right and bool(view.gear) == bool(gear):
                score.right_slots += 1
            else:
                score.missed(f"{text} {view.slot.name}: {view.content.value}, where {gear} is right")


def compare_layouts(vision, shown, layouts, score, report=lambda text: None):
    """Shows each layout (name, Layout or None) and adds what a vision finds in it to a score."""
    for name, layout in layouts:
        truth = shown.show(layout)
        before = len(score.troubles)
        vision.compare(truth, score, name)
        report(f"{name}: {len(truth)} trays, {'; '.join(score.troubles[before:]) or 'all right'}")


def layouts_from(seed, count, gap_mm, margin_mm=0.0):
    """The recorded layout, then random ones."""
    yield "recorded layout", None
    for number in range(seed, seed + count):
        yield f"layout {number}", Layout(number, gap_mm=gap_mm, any_gears=True, margin_mm=margin_mm)


def options_of(parser):
    parser.add_argument("--count", type=int, default=20, help="number of random layouts (default 20)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the first layout (default 1)")
    parser.add_argument("--gap-mm", type=float, default=GAP_MM, help="least gap between trays (default 4)")
    parser.add_argument("--margin-mm", type=float, default=0, help="within the robot's view (default 0)")
    parser.add_argument("--json", type=pathlib.Path, help="file for the summary")
    return parser.parse_args()


def main(make_vision=OwnVision):
    options = options_of(argparse.ArgumentParser(description="Compare a detection with the true cell."))
    score = Score()
    with PicturedCell() as shown:
        layouts = layouts_from(options.seed, options.count, options.gap_mm, options.margin_mm)
        compare_layouts(make_vision(shown), shown, layouts, score, lambda text: print(text, flush=True))
    summary = {"layouts": options.count + 1, **score.summary()}
    print(json.dumps(summary, indent=2))
    if options.json:
        options.json.write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    return 1 if score.troubles else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except unittest.SkipTest as error:
        sys.exit(str(error))
