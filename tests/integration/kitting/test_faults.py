"""Every kind of injected fault: the controller notices it by its wires and the job ends as the table in
clients/kitting/README.md says. The same job with the same fault fails when the controller's
reactions are off, and succeeds so without the fault: hence the fault causes the failure."""

import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from fault_table import FAULTS, JOBS, write_scenario
from running_cell import BINARIES, CONTROLLER, PATIENCE, ROOT

AS_EXPECTED, ANOTHER_OUTCOME = 0, 1
# The kinds that also run with the reactions off: a fifth, all of them with APRSIM_THOROUGH.
BLIND_KINDS = list(FAULTS)[:: 1 if "APRSIM_THOROUGH" in os.environ else 5]


def stated():
    """For each kind in the controller's README: the event that reports it, and the outcome."""
    rows = {}
    for line in (CONTROLLER / "README.md").read_text(encoding="utf-8").splitlines():
        columns = [column.strip() for column in line.strip("|").split("|")]
        if len(columns) == 4 and re.fullmatch(r"`[a-z]+(-[a-z]+)+`", columns[0]):
            events = re.findall(r"`([a-z_]+)`", columns[1])
            rows[columns[0].strip("`")] = (events, columns[2], columns[3])
    return rows


def kinds_of_the_cell():
    text = (ROOT / "world" / "api" / "faults" / "FAULTS.md").read_text(encoding="utf-8")
    kinds = re.findall(r"^\| `([a-z]+(?:-[a-z]+)+)` \| [^|]* \| [^|]* \| [^|]+ \|$", text, re.M)
    # The controller commands the robots by CRCL and reads lines, no pictures.
    return [kind for kind in kinds if not kind.startswith(("simple-message-", "picture-"))]


class FaultTest(unittest.TestCase):
    def run_job(self, kind, **how):
        """The scenario's exit code, its text, and the names of what the controller told."""
        with tempfile.TemporaryDirectory() as folder:
            path = write_scenario(pathlib.Path(folder), kind, **how)
            wall = FAULTS[kind].wall and how.get("struck", True)
            done = subprocess.run(
                [os.path.join(BINARIES, "aprsim"), "scenario", "run", str(path), "--report", folder,
                 "--seed", str(FAULTS[kind].seed), *(["--speed", "1"] if wall else ["--virtual"])],
                capture_output=True,
                text=True,
                timeout=180 * PATIENCE,
            )
            told = []
            for line in (pathlib.Path(folder) / "controller.out").read_text().splitlines():
                told.append(json.loads(line).get("event"))
            log = (pathlib.Path(folder) / "controller.log").read_text()
        self.assertNotIn("Traceback", log)
        return done.returncode, done.stdout + done.stderr + log, told

    def check(self, *prefixes):
        kinds = [kind for kind in FAULTS if kind.startswith(prefixes)]
        self.assertTrue(kinds)
        rows = stated()
        for kind in kinds:
            with self.subTest(kind):
                code, text, told = self.run_job(kind)
                self.assertEqual(code, AS_EXPECTED, text)
                for event in rows[kind][0]:
                    self.assertIn(event, told, text)
                if kind not in BLIND_KINDS:
                    continue
                code, text, told = self.run_job(kind, blind=True)
                self.assertEqual(code, ANOTHER_OUTCOME, text)
                self.assertTrue({"take", "give_up", "detect_again"} & set(told), f"it works: {told}")

    def test_arm(self):
        self.check("robot-", "joint-", "encoder-", "drive-", "protective-", "cell-", "curtain-")

    def test_calibration_and_the_controller(self):
        self.check("controller-", "base-", "tool-", "crcl-")

    def test_gripper(self):
        self.check("gripper-")

    def test_belt(self):
        self.check("belt-", "photo-eye-", "tray-jammed")

    def test_plc(self):
        self.check("modbus-")

    def test_parts_and_trays(self):
        self.check("part-", "tray-shifted", "foreign-")

    def test_cameras(self):
        self.check("camera-")

    def test_without_a_fault_nothing_goes_wrong_and_the_blind_controller_does_the_jobs_too(self):
        notices = {event for events, _, _ in stated().values() for event in events}
        for job in JOBS:
            kind = next(kind for kind, fault in FAULTS.items() if fault.job == job and not fault.wall)
            for blind in (False, True):
                with self.subTest(job, blind=blind):
                    code, text, told = self.run_job(kind, blind=blind, struck=False)
                    self.assertEqual(code, AS_EXPECTED, text)
                    self.assertFalse(notices & set(told), told)

    def test_every_kind_is_run_and_is_in_the_table(self):
        kinds = kinds_of_the_cell()
        self.assertGreater(len(kinds), 50)
        self.assertEqual(sorted(FAULTS), sorted(kinds))
        self.assertEqual(list(stated()), kinds, "in the order of FAULTS.md")
        for kind, (events, notices, becomes) in stated().items():
            self.assertTrue(events and notices and becomes, kind)


if __name__ == "__main__":
    unittest.main()
