"""Scenarios run from Python."""

import pathlib
import tempfile
import unittest

from aprsim import ScenarioError, run_scenario, scenarios
from running_cell import PATIENCE


class ScenarioTest(unittest.TestCase):
    SCENARIO = """description: an order that nobody fills
scene: aprs
orders:
  - {name: kit, tray: sku_kit_m2l1_vessel, slots: {lg_1: sku_part_large_gear}}
stop: {time_limit_s: 1}
expect: {kits_right: 1, drops: 0}
scoring: {baseline_s: 20, baseline_score: 5}
"""

    def test_runs_and_tells_what_came_of_it(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "idle.yaml"
            file.write_text(self.SCENARIO, encoding="utf-8")
            report = run_scenario(
                file, seed=3, virtual=False, speed="max", controller="sleep 60",
                timeout_s=100 * PATIENCE,
            )
            self.assertEqual((report.scenario, report.seed), ("idle", 3))
            self.assertFalse(report.as_expected)
            self.assertEqual({v.measure: v.kept for v in report.verdicts}, {"kits_right": False, "drops": True})
            self.assertEqual(report.measures["kits_right"], 0)
            with self.assertRaisesRegex(ScenarioError, "exit code 2"):
                run_scenario(pathlib.Path(folder) / "none.yaml")
            with self.assertRaisesRegex(ScenarioError, "virtual"):
                run_scenario(file, speed=2)

    def test_lists_those_that_ship(self):
        self.assertIn("clean_2017", scenarios())


if __name__ == "__main__":
    unittest.main()
