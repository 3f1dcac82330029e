"""Random layouts of trays in the laboratory of 2025: each robot has an empty kit and part trays with what
the kit takes, all in its camera's view and in its reach. As a program: the kitting controller fills the
kits of a number of layouts over Simple Message, in virtual time.

    random_layouts.py [--count 20] [--seed 1]
"""

import argparse
import itertools
import math
import pathlib
import random
import re
import sys
import tempfile

from running_cell import BINARIES, ROOT, Controller, Daemon, filled_slots, snapshot

# On the path that running_cell sets.
import cell as cells
from geometry import Pose2

SCENES = ROOT / "world" / "scenes"
PLACED_MM = 0.5
PACERS = "gripper.fanuc,gripper.motoman,vision.fanuc,vision.motoman"
# Part trays of each kit, with the number of gears that the kit takes from them.
SUPPLIES = {
    "sku_kit_m2l1_vessel": {"sku_medium_gear_vessel": 2, "sku_large_gear_vessel": 1},
    "sku_kit_s2l2_vessel": {"sku_small_gear_vessel": 2, "sku_large_gear_vessel": 2},
}
GAP_MM = 4.0  # between trays
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
    """Trays at random places that do not meet."""

    def __init__(self, seed):
        self.chances = random.Random(seed)
        self.cell = cells.read_cell("aprs_2025")
        self.outlines = outlines()
        self.trays = []  # (name, type, pose, slots with gears)
        self.kits = []
        while not self._draw():
            pass

    def _draw(self):
        self.trays, self.kits, numbers = [], [], itertools.count(1)
        for robot in self.cell.robots.values():
            placed = []
            kit = self.chances.choice(sorted(SUPPLIES))
            for kind in (kit, *SUPPLIES[kit]):
                pose = self._place(robot, kind, placed)
                if pose is None:
                    return False
                placed.append([pose.point(corner) for corner in self.outlines[kind]])
                slots = [slot.name for slot in self.cell.trays[kind].slots]
                need = SUPPLIES[kit].get(kind, 0)
                gears = self.chances.sample(slots, self.chances.randint(need, len(slots))) if need else []
                name = f"{robot.name}_{next(numbers):02}"
                self.trays.append((name, kind, pose, robot.name, gears))
                if not need:
                    self.kits.append(name)
        return True

    def _place(self, robot, kind, placed):
        (x0, y0), (x1, y1) = robot.view_mm
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
                and all(apart(corners, other, GAP_MM) for other in placed)
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


def fill_kits(scene, kits):
    """One job in a scene. Its exit code, report, output, wrong slots, and seconds of the cell."""
    options = ("--time", "virtual", "--pacers", PACERS, "--no-web")
    daemon = Daemon(BINARIES, "--scene", str(scene), *options)
    controller = None
    try:
        controller = Controller(
            *("--cell", "aprs_2025", "--wires", "simple-message", "--clock", "polls", "--poll-ms", "25"),
            ports_file=daemon.ports_file,
        )
        code, report = controller.wait()
        state = snapshot(daemon)
        wrong = wrong_slots(state, cells.read_cell("aprs_2025"), kits)
        if state["world_fault"] or int(state["physics_faults"]):
            wrong.append(f"physics: {state['world_fault']} {state['physics_faults']}")
        return code, report, "".join(controller.lines), wrong, int(state["step"]) / 1e3
    finally:
        if controller is not None and controller.process.poll() is None:
            controller.kill()
        daemon.close()


def main():
    parser = argparse.ArgumentParser(description="Fill the kits of random layouts.")
    parser.add_argument("--count", type=int, default=20, help="number of layouts (default 20)")
    parser.add_argument("--seed", type=int, default=1, help="seed of the first layout (default 1)")
    arguments = parser.parse_args()
    failed = 0
    for seed in range(arguments.seed, arguments.seed + arguments.count):
        layout = Layout(seed)
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder) / "scene.yaml"
            scene.write_text(layout.scene(), encoding="utf-8")
            code, report, text, wrong, seconds = fill_kits(scene, layout.kits)
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
