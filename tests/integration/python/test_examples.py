"""Every example of the package runs as it stands."""

import os
import subprocess
import sys
import unittest

from aprsim import Daemon
from running_cell import PACKAGE, PATIENCE

# A line that each prints. Examples that run a whole scenario are covered by the scenarios' own tests, the
# one that learns by test_learn.
SAID = {
    "belt_table.py": "large_gear_vessel_3",
    "episode.py": "True",
    "follow.py": "SUCCESSFUL, at most 0.000 mrad",
    "leaking_gripper.py": "gripper-leak: state 3",
    "look.py": "the tool is 50.0 mm lower",
    "pick_gear.py": "holds part_medium_gear_1, 60.0 mm over its tray",
    "two_arms.py": "motoman",
}
WITHOUT_RUN = {"job.py", "learn.py"}


class Examples(unittest.TestCase):
    def test_run_as_they_stand(self):
        names = {path.name for path in (PACKAGE / "examples").glob("*.py")}
        self.assertEqual(names, set(SAID) | WITHOUT_RUN)
        for name, words in SAID.items():
            with self.subTest(name), Daemon(speed=5, start_s=60 * PATIENCE) as daemon:
                done = subprocess.run(
                    [sys.executable, str(PACKAGE / "examples" / name)],
                    env={**os.environ, "APRSIM_PORTS_FILE": str(daemon.ports_file)},
                    capture_output=True, text=True, timeout=60 * PATIENCE,
                )
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn(words, done.stdout)


if __name__ == "__main__":
    unittest.main()
