"""The kitting controller in a cell with a wall between its parts and its kits, of which it knows
nothing: with planning it works, without it hits the wall."""

import pathlib
import subprocess
import tempfile
import unittest

from running_cell import BINARIES, PATIENCE, ROOT, snapshot
from test_cell import KittingTest

SCENES = ROOT / "world" / "scenes"
# Between the trays with gears and the kits before the Fanuc, higher than the approaches.
WALL = "  - {name: wall, size_m: [0.006, 0.42, 0.12], xyz_m: [0.23, -1.14, 0.975]}\n"
KITS = ("kit_m2l1_vessel_1", "kit_m2l1_vessel_2")


def scene_with_wall(folder, planning):
    """The default scene with a wall; its Fanuc plans in this way."""
    text = (SCENES / "aprs.yaml").read_text()
    for name in ("gears_2017", "robots"):
        text = text.replace(f"types/{name}.yaml", str(SCENES / "types" / f"{name}.yaml"))
    text = text.replace("  - name: fanuc\n", f"  - name: fanuc\n    planning: {planning}\n", 1)
    plate = text.index("  - {name: fanuc_base_plate")
    file = pathlib.Path(folder) / f"wall_{planning}.yaml"
    file.write_text(text[:plate] + WALL + text[plate:])
    return file


class WallTest(KittingTest):
    def kitting(self, planning):
        """A job of the Fanuc alone; the controller's exit code and report, and the events of the
        cell."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.start(scene_with_wall(folder.name, planning))
        controller = self.controller("--robots", "fanuc", "--no-belt")
        code, report = controller.wait()
        return code, report, "".join(controller.lines)

    def touches(self):
        """Contacts of the wall that have begun, one a line."""
        done = subprocess.run(
            [f"{BINARIES}/aprsim", "--ports-file", self.daemon.ports_file, "events", "--past"]
            + ["--after", "0", "--kind", "contact-begun", "--name", "wall", "--json"],
            capture_output=True,
            text=True,
            timeout=60 * PATIENCE,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.splitlines()

    def test_with_planning_it_works_round_the_wall(self):
        _, report, text = self.kitting("avoid")
        self.assertEqual(report["counts"].get("robot_error", 0), 0, text)
        self.assert_kits(full=KITS)
        self.assertEqual(self.touches(), [])
        self.assertEqual(snapshot(self.daemon)["robots"][0]["planning"], "PLANNING_MODE_AVOID")

    def test_without_it_hits_the_wall(self):
        code, _, text = self.kitting("direct")
        self.assertNotEqual(code, 0)
        self.assertIn("wall", text)
        self.assertNotEqual(self.touches(), [])


if __name__ == "__main__":
    unittest.main()
