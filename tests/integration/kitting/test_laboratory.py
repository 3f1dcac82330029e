"""The laboratory's action lists, run by the kitting controller in virtual time: each ends as the table
in clients/kitting/README.md says."""

import os
import pathlib
import re
import unittest

from running_cell import BINARIES, CONTROLLER, PATIENCE, Controller, Daemon, filled_slots, snapshot

import cell as cells

REFERENCE = os.environ.get("APRSIM_REFERENCE_DIR", "")
LISTS = pathlib.Path(REFERENCE) / "aprs" / "data" / "actions"
PLACED_MM = 0.5


def stated_endings():
    """For each list: robot, the list to run before it, exit code, parts then in kits, words of the
    failure."""
    rows = {}
    for line in (CONTROLLER / "README.md").read_text(encoding="utf-8").splitlines():
        columns = [column.strip() for column in line.strip("|").split("|")]
        if len(columns) != 6 or not re.fullmatch(r"`\w+[\w-]*`", columns[0]):
            continue
        name, robot, before, code, parts, ending = columns
        words = re.findall(r"`([^`]+)`", ending)
        rows[name.strip("`")] = (robot, before.strip("`"), int(code), int(parts), words)
    return rows


@unittest.skipUnless(REFERENCE, "no reference material: APRSIM_REFERENCE_DIR is not set")
class ActionListsTest(unittest.TestCase):
    def run_list(self, daemon, robot, name):
        """Exit code, and what it said of failures."""
        controller = Controller(
            "--clock", "polls", "--poll-ms", "25", "--actions", f"{robot}={LISTS / name}.txt",
            ports_file=daemon.ports_file,
        )
        self.addCleanup(lambda: controller.process.poll() is None and controller.kill())
        out, _ = controller.process.communicate(timeout=200 * PATIENCE)
        self.assertNotIn("Traceback", out)
        return controller.process.returncode, out

    def run_lists(self, robot):
        rows = {name: row for name, row in stated_endings().items() if row[0] == robot}
        self.assertGreater(len(rows), 3)
        cell = cells.read_cell("aprs")
        for name, (_, before, code, parts, words) in rows.items():
            with self.subTest(name):
                pacers = f"crcl.{robot},vision.{robot}"
                daemon = Daemon(
                    BINARIES, "--scene", "aprs", "--time", "virtual", "--pacers", pacers, "--no-web"
                )
                try:
                    if before:
                        self.assertEqual(self.run_list(daemon, robot, before)[0], 0, before)
                    got, out = self.run_list(daemon, robot, name)
                    self.assertEqual(got, code, out)
                    for text in words:
                        self.assertIn(text, out)
                    state = snapshot(daemon)
                finally:
                    daemon.close()
                self.assertEqual((state["world_fault"], int(state["physics_faults"])), ("", 0))
                self.assertFalse(any(one["gripper"]["holding"] for one in state["robots"]))
                kits = filled_slots(state, cell)
                filled = [slot for kit in kits.values() for slot in kit.values() if slot]
                self.assertEqual(len(filled), parts, kits)
                for _, error_mm in filled:
                    self.assertLess(error_mm, PLACED_MM)

    def test_fanuc(self):
        self.run_lists("fanuc")

    def test_motoman(self):
        self.run_lists("motoman")

    def test_every_list_is_in_the_table(self):
        lists = {path.stem for path in LISTS.glob("*actions*.txt")}
        lists |= {path.stem for path in LISTS.glob("*move_one*.txt")}
        self.assertEqual(set(stated_endings()), lists)


if __name__ == "__main__":
    unittest.main()
