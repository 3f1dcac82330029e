"""Random layouts of trays in the laboratory of 2025: each robot has an empty kit and part trays with what
the kit takes, all in its camera's view and in its reach. As a program: the kitting controller fills the
kits of a number of layouts over Simple Message, in virtual time.

    random_layouts.py [--count 20] [--seed 1]
"""

import argparse
import itertools
import json
import math
import os
import pathlib
import random
import re
import socket
import subprocess
import sys
import tempfile

from running_cell import BINARIES, PATIENCE, ROOT, Controller, Daemon, eventually, filled_slots, snapshot

# On the path that running_cell sets.
import cell as cells
from geometry import Pose2

SCENES = ROOT / "world" / "scenes"
PLACED_MM = 0.5
PICTURE_PACERS = "gripper.fanuc,gripper.motoman"
PACERS = PICTURE_PACERS + ",vision.fanuc,vision.motoman"
# Part trays of each kit, with the number of gears that the kit takes from them.
SUPPLIES = {
    "sku_kit_m2l1_vessel": {"sku_medium_gear_vessel": 2, "sku_large_gear_vessel": 1},
    "sku_kit_s2l2_vessel": {"sku_small_gear_vessel": 2, "sku_large_gear_vessel": 2},
}
GAP_MM = 4.0  # between trays
LABELS = 50  # of the dictionary of markers
MOST_TRAYS = 4  # of a robot, where they fit
REACH_MARGIN_MM = 15.0


def outlines():
    """The corners of each type of tray, in its frame [mm]."""
    text = (SCENES / "types" / "trays_2025.yaml").read_text(encoding="utf-8")
    found = {}
    for name, corners in re.findall(r"^  (sku_\w+):\n    kind: \w+\n    outline_m:\n(.*?)\n    th", text, re.M | re.S):
        numbers = [1e3 * float(n) for n in re.findall(r"-?\d+\.?\d*", corners)]
        found[name] = list(zip(numbers[::2], numbers[1::2]))
    return found


def apart(a, b, gap):
    """Whether a side of one of two convex polygons keeps the other at a distance."""
    for own, other in ((a, b), (b, a)):
        for p, q in zip(own, own[1:] + own[:1]):
            n = (q[1] - p[1], p[0] - q[0])
            off = min((x - p[0]) * n[0] + (y - p[1]) * n[1] for x, y in other)
            if off > gap * math.hypot(*n):
                return True
    return False


class Layout:
    """Trays at random places that do not meet. With `any_gears` there are two to MOST_TRAYS trays a robot, as
    far as they fit, of any type, with any number of gears and any label. Trays stay `margin_mm` within the
    robot's view."""

    def __init__(self, seed, gap_mm=GAP_MM, any_gears=False, margin_mm=0.0):
        self.chances = random.Random(seed)
        self.gap_mm, self.any_gears, self.margin_mm = gap_mm, any_gears, margin_mm
        self.cell = cells.read_cell("aprs_2025")
        self.outlines = outlines()
        self.trays = []  # (name, type, pose, slots with gears)
        self.kits = []
        while not self._draw():
            pass

    def _draw(self):
        self.trays, self.kits = [], []
        numbers = itertools.count(1)
        if self.any_gears:
            numbers = iter(self.chances.sample(range(LABELS), LABELS))
        for robot in self.cell.robots.values():
            placed = []
            for kind, least, most in self._contents():
                pose = self._place(robot, kind, placed)
                if pose is None and not self.any_gears:
                    return False
                if pose is None:
                    continue
                placed.append([pose.point(corner) for corner in self.outlines[kind]])
                slots = [slot.name for slot in self.cell.trays[kind].slots]
                gears = self.chances.sample(slots, self.chances.randint(least, most)) if most else []
                name = f"{robot.name}_{next(numbers):02}"
                self.trays.append((name, kind, pose, robot.name, gears))
                if not most:
                    self.kits.append(name)
        return True

    def _contents(self):
        """The types of a robot's trays, with the least and greatest number of their gears."""
        slots = {name: len(tray.slots) for name, tray in self.cell.trays.items()}
        if self.any_gears:
            kinds = self.chances.choices(sorted(slots), k=self.chances.randint(2, MOST_TRAYS))
            return [(kind, 0, slots[kind]) for kind in kinds]
        kit = self.chances.choice(sorted(SUPPLIES))
        return [(kit, 0, 0), *((kind, need, slots[kind]) for kind, need in SUPPLIES[kit].items())]

    def _place(self, robot, kind, placed):
        (x0, y0), (x1, y1) = robot.view_mm
        x0, y0 = x0 + self.margin_mm, y0 + self.margin_mm
        x1, y1 = x1 - self.margin_mm, y1 - self.margin_mm
        near, far = robot.reach_mm[0] + REACH_MARGIN_MM, robot.reach_mm[1] - REACH_MARGIN_MM
        for _ in range(400):
            pose = Pose2(
                self.chances.uniform(x0, x1),
                self.chances.uniform(y0, y1),
                self.chances.uniform(-math.pi, math.pi),
            )
            corners = [pose.point(corner) for corner in self.outlines[kind]]
            slots = [pose.point(slot.xy_mm) for slot in self.cell.trays[kind].slots]
            if (
                all(x0 <= x <= x1 and y0 <= y <= y1 for x, y in corners)
                and all(near <= math.dist(slot, robot.base_mm[:2]) <= far for slot in slots)
                and all(apart(corners, other, self.gap_mm) for other in placed)
            ):
                return pose
        return None

    def scene(self):
        """The text of a scene file: the laboratory's with these trays."""
        text = (SCENES / "aprs_2025.yaml").read_text(encoding="utf-8")
        text = text[: text.index("\ntrays:\n")].replace("types/", f"{SCENES}/types/")
        lines, numbers = [text, "trays:"], itertools.count(1)
        for name, kind, pose, robot, gears in self.trays:
            types = {slot.name: slot.part for slot in self.cell.trays[kind].slots}
            names = (f"{slot}: {types[slot].removeprefix('sku_part_')}_{next(numbers)}" for slot in gears)
            lines += [
                f"  - name: {name}",
                f"    type: {kind}",
                "    on: optical_table",
                f"    xy_m: [{pose.x / 1e3:.4f}, {pose.y / 1e3:.4f}]",
                f"    yaw_deg: {math.degrees(pose.yaw):.2f}",
                *([f"    gears: {{{', '.join(names)}}}"] if gears else []),
                f"    reachable_by: [{robot}]",
            ]
        return "\n".join(lines) + "\n"


def wrong_slots(state, cell, kits=None):
    """Slots of the kits (None: of all) without a part of their type within PLACED_MM of their centre."""
    types = {body["name"]: body["type"] for body in state["bodies"]}
    wrong = []
    for name, slots in filled_slots(state, cell).items():
        if kits is not None and name not in kits:
            continue
        for slot in cell.trays[types[name]].slots:
            found = slots[slot.name]
            if found is None or found[0] != slot.part or found[1] > PLACED_MM:
                wrong.append(f"{slot.name} of {name}: {found}")
    return wrong


class Vision:
    """The example of a vision stack beside a cell: it sees the cell's pictures, and its lines take the
    place of the cell's."""

    def __init__(self, daemon, folder):
        self.ports_file = folder / "seen.json"
        self.log = open(folder / "vision.log", "w+", encoding="utf-8")
        options = ("--cell", "aprs_2025", "--maps", "cell", "--ports-file", str(daemon.ports_file))
        self.process = subprocess.Popen(
            [sys.executable, "-m", "clients.vision", *options, "--any-port", "--write-ports", str(self.ports_file)],
            env=os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "clients" / "python")])},
            stdout=self.log,
            stderr=self.log,
        )
        try:
            eventually(lambda: self.ports_file.exists() or self.process.poll() is not None, 60, "ports of the vision")
            self._await_lines()
        except BaseException:
            self.close()
            raise

    def _await_lines(self):
        if self.process.poll() is not None:
            raise AssertionError(f"the vision has ended: {self.text()}")
        ports = json.loads(self.ports_file.read_text(encoding="utf-8"))
        for name in (name for name in ports if name.startswith("vision.")):
            with socket.create_connection(("127.0.0.1", ports[name]), 10) as feed:
                feed.settimeout(120 * PATIENCE)
                if not feed.recv(1):
                    raise AssertionError(f"{name} sends no line: {self.text()}")

    def text(self):
        self.log.seek(0)
        return self.log.read()

    def close(self):
        self.process.terminate()
        self.process.wait(30)
        self.log.close()


def fill_kits(scene, kits, pictures=False):
    """One job in a scene, in virtual time. Its exit code, report, output, wrong slots, and seconds of the cell.
    With `pictures` the example of a vision stack gives the lines, which sees pictures only."""
    pacers = PICTURE_PACERS if pictures else PACERS
    daemon = Daemon(BINARIES, "--scene", str(scene), "--time", "virtual", "--pacers", pacers, "--no-web")
    controller = vision = None
    try:
        ports_file, options = daemon.ports_file, ()
        if pictures:
            vision = Vision(daemon, pathlib.Path(scene).parent)
            ports_file, options = vision.ports_file, ("--polls-per-line", "4")
        controller = Controller(
            *("--cell", "aprs_2025", "--wires", "simple-message", "--clock", "polls", "--poll-ms", "25"),
            *options,
            ports_file=ports_file,
        )
        code, report = controller.wait(1800 if pictures else 120)
        state = snapshot(daemon)
        wrong = wrong_slots(state, cells.read_cell("aprs_2025"), kits)
        if state["world_fault"] or int(state["physics_faults"]):
            wrong.append(f"physics: {state['world_fault']} {state['physics_faults']}")
        return code, report, "".join(controller.lines), wrong, int(state["step"]) / 1e3
    finally:
        if controller is not None and controller.process.poll() is None:
            controller.kill()
        if vision is not None:
            vision.close()
        daemon.close()


def main():
    parser = argparse.ArgumentParser(description="Fill the kits of random layouts.")
    parser.add_argument("--count", type=int, default=20, help="number of layouts (default 20)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the first layout (default 1)")
    parser.add_argument("--pictures", action="store_true", help="see pictures only, by clients/vision")
    arguments = parser.parse_args()
    failed = 0
    for seed in range(arguments.seed, arguments.seed + arguments.count):
        layout = Layout(seed)
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder) / "scene.yaml"
            scene.write_text(layout.scene(), encoding="utf-8")
            code, report, text, wrong, seconds = fill_kits(scene, layout.kits, arguments.pictures)
        good = code == 0 and not wrong
        failed += not good
        by = {name: robot for name, _, _, robot, _ in layout.trays if name in layout.kits}
        counts = {key: count for key, count in report["counts"].items() if count}
        print(f"layout {seed}: {'filled' if good else 'FAILED'}, {seconds:.1f} s, kits {by}, {counts}", flush=True)
        if not good:
            print(f"exit code {code}; {wrong}\n{text}{layout.scene()}")
    print(f"{arguments.count - failed} of {arguments.count} layouts filled")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
