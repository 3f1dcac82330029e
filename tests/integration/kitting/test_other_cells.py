"""Cells without gears, which the same controller fills: kit and supply at random places. In virtual time,
so that neither the machine's speed nor its load decides."""

import random
import tempfile
import unittest
from pathlib import Path

from running_cell import BINARIES, Controller, Daemon, filled_slots, snapshot

# On the path that running_cell sets.
import cell as cells

TRIALS = 3


def overlay(base, trays):
    """A scene with trays elsewhere: x, y [m] and yaw [degrees] by name."""
    lines = [f"base: {base}", "trays:"]
    for name, (x, y, yaw) in trays.items():
        lines.append(f"  - {{name: {name}, xy_m: [{x:.4f}, {y:.4f}], yaw_deg: {yaw:.2f}}}")
    return "\n".join(lines) + "\n"


class OtherCellsTest(unittest.TestCase):
    def fill(self, scene, robot, kit, trays, most_mm):
        folder = self.enterContext(tempfile.TemporaryDirectory())
        file = Path(folder) / "scene.yaml"
        file.write_text(overlay(scene, trays), encoding="utf-8")
        pacers = f"crcl.{robot},vision.{robot}"
        daemon = Daemon(
            BINARIES, "--scene", str(file), "--time", "virtual", "--pacers", pacers, "--no-web"
        )
        self.addCleanup(daemon.close)
        controller = Controller(
            "--cell", scene, "--clock", "polls", "--poll-ms", "25", ports_file=daemon.ports_file
        )
        self.addCleanup(lambda: controller.process.poll() is None and controller.kill())
        code, report = controller.wait()
        text = "".join(controller.lines)
        self.assertEqual(code, 0, f"{trays}: {text}")
        self.assertEqual(report["counts"].get("robot_error", 0), 0, f"{trays}: {text}")
        state = snapshot(daemon)
        self.assertEqual((state["world_fault"], int(state["physics_faults"])), ("", 0))
        cell = cells.read_cell(scene)
        wanted = {slot.name: slot.part for tray in cell.trays.values() if tray.is_kit for slot in tray.slots}
        found = filled_slots(state, cell)[kit]
        self.assertEqual(
            {name: part and part[0] for name, part in found.items()}, wanted, f"{trays}: {text}"
        )
        self.assertLess(max(error for _, error in found.values()), most_mm, f"{trays}: {found}")
        daemon.close()

    def test_pegs_into_holes_with_hardly_any_clearance(self):
        chances = random.Random(1)
        for _ in range(TRIALS):
            trays = {
                "board": (0.45 + chances.uniform(-0.03, 0.03), -0.1, chances.uniform(-10, 10)),
                "rack": (0.45 + chances.uniform(-0.03, 0.03), 0.03, chances.uniform(-10, 10)),
            }
            # The holes are 0.025 mm wider than the pegs on each side; seated pegs may tilt in them.
            self.fill("taskboard", "fanuc", "board", trays, 0.05)

    def test_keys_and_nuts_into_pockets_of_their_outlines(self):
        chances = random.Random(3)
        for _ in range(TRIALS):
            trays = {
                "board": (0.45 + chances.uniform(-0.03, 0.03), -0.1, chances.uniform(-20, 20)),
                "rack": (0.45 + chances.uniform(-0.03, 0.03), 0.03, chances.uniform(-20, 20)),
            }
            # The pockets are 0.05 mm wider than the parts on each side. A part at another yaw stands on the
            # mouth, where its distance is that of the depth.
            self.fill("taskboard_keys", "fanuc", "board", trays, 0.2)

    def test_parts_of_four_kinds_by_vacuum(self):
        chances = random.Random(2)
        for _ in range(TRIALS):
            trays = {
                name: (0.5 + chances.uniform(-0.03, 0.03), y, chances.uniform(-5, 5))
                for name, y in (("kit", 0.28), ("bin", -0.28))
            }
            self.fill("ariac", "ur5e", "kit", trays, 0.5)


class TwoArmsTest(unittest.TestCase):
    """Two arms of other makers fill a kit each, with gears that the belt brings."""

    ROBOTS = ("ur5e", "irb120")
    MOST_MM = 0.5

    def setUp(self):
        pacers = ",".join(f"{wire}.{robot}" for wire in ("crcl", "vision") for robot in self.ROBOTS)
        self.daemon = Daemon(
            BINARIES, "--scene", "two_arms", "--time", "virtual", "--pacers", pacers, "--no-web"
        )
        self.addCleanup(self.daemon.close)

    def test_both_kits_are_filled(self):
        controller = Controller(
            "--cell", "two_arms", "--clock", "polls", "--poll-ms", "25",
            ports_file=self.daemon.ports_file,
        )
        self.addCleanup(lambda: controller.process.poll() is None and controller.kill())
        code, report = controller.wait(600)
        text = "".join(controller.lines)
        self.assertEqual(code, 0, text)
        self.assertEqual(report["counts"].get("robot_error", 0), 0, text)
        self.assertGreater(report["counts"].get("belt", 0), 0, text)
        state = snapshot(self.daemon)
        self.assertEqual((state["world_fault"], int(state["physics_faults"])), ("", 0))
        cell = cells.read_cell("two_arms")
        found = filled_slots(state, cell)
        self.assertEqual(set(found), {"kit_s2l2", "kit_m2l1"})
        for kit, slots in found.items():
            wanted = {slot.name: slot.part for slot in cell.trays[f"sku_{kit}_vessel"].slots}
            self.assertEqual({name: part and part[0] for name, part in slots.items()}, wanted, text)
            self.assertLess(max(error for _, error in slots.values()), self.MOST_MM, found)


if __name__ == "__main__":
    unittest.main()
