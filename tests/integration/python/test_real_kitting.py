"""A kitting job by the product's own controller with one real and one simulated robot: a second daemon plays
the Fanuc, its camera and the PLC of the belt, as docs/real.md has them; the Motoman works in the cell alone."""

import json
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from aprsim.calibration.modbus_units import DIRECTION, RUN, SPEED
from aprsim.real.base.device_socket import DeviceSocket
from aprsim.real.belts.modbus_wire import HEADER
from real_support import HOST, TwoCells
from running_cell import PACKAGE, PATIENCE, ROOT, await_that

KITTING = ROOT / "clients" / "kitting"
sys.path.insert(0, str(KITTING))

import cell as kitting_cell  # noqa: E402
from vision import canonical  # noqa: E402

REAL_KITS = ("kit_m2l1_vessel_1", "kit_m2l1_vessel_2")  # on the Fanuc's table
SIMULATED_KITS = ("kit_s2l2_vessel_1", "kit_s2l2_vessel_2")  # on the belt
PLACED_MM = 0.5
MOVED_MM = 4.0  # a camera's mirror moves what is farther away than 3 mm
NEAR_MM = 10.0  # a slot's part


class MixedKittingTest(TwoCells):
    def setUp(self):
        super().setUp()
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.trays = kitting_cell.read_cell("aprs").trays

    def program(self):
        """`aprsim.real run` with the file of docs/real.md, on the ports of the second daemon. Returns the
        process and the ports for controllers."""
        text = (ROOT / "docs" / "real.md").read_text(encoding="utf-8").partition("## A mixed cell")[2]
        text = text.partition("```yaml\n")[2].partition("```")[0]
        ports = self.real.endpoints.ports
        for name, key in (("10:64444", "crcl.fanuc"), ("60:4000", "vision.fanuc"), ("50:502", "modbus")):
            self.assertIn(f"192.168.1.{name}", text)
            text = text.replace(f"192.168.1.{name}", f"{HOST}:{ports[key]}")
        text = re.sub(r'listen: "127.0.0.1:\d+"', f'listen: "{HOST}:0"', text)
        file = self.folder / "mixed.yaml"
        file.write_text(f"patience_s: {min(60 * PATIENCE, 60)}\n{text}")
        log = self.folder / "real.log"
        with log.open("w") as out:
            process = subprocess.Popen(
                [sys.executable, "-m", "aprsim.real", "run", str(file), "--ports-file", self.ours.ports_file],
                stdout=out, stderr=out, env=os.environ | {"PYTHONPATH": str(PACKAGE), "PYTHONUNBUFFERED": "1"},
            )  # fmt: skip
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        found = {}
        for key, name in (("crcl.fanuc", "fanuc"), ("vision.fanuc", "camera of fanuc"), ("modbus", "conveyor")):
            pattern = re.compile(rf" {name}: controllers.*:(\d+)$", re.MULTILINE)
            await_that(lambda: pattern.search(log.read_text()), f"{name}: {log.read_text()}")
            found[key] = int(pattern.search(log.read_text())[1])
        await_that(lambda: "fanuc: follows" in log.read_text(), log.read_text())
        return process, found

    def slots(self, cell):
        """For every kit tray: the slots with the type of the part in each, and the part's distance from the
        slot's centre [mm]; None for an empty one."""
        bodies = cell.snapshot(["bodies"]).bodies.values()
        gears = [body for body in bodies if canonical(body.type).startswith("sku_part")]
        out = {}
        for tray in bodies:
            kind = self.trays.get(canonical(tray.type))
            if kind is None or not kind.is_kit:
                continue
            out[tray.name] = {}
            for slot in kind.slots:
                centre = (tray.pose @ [*(1e-3 * np.array(slot.xy_mm[:2])), 0, 1])[:2]
                away_mm = [1e3 * float(np.linalg.norm(gear.pose[:2, 3] - centre)) for gear in gears]
                nearest = int(np.argmin(away_mm))
                if away_mm[nearest] > NEAR_MM:
                    out[tray.name][slot.name] = None
                else:
                    self.assertEqual(canonical(gears[nearest].type), slot.part, f"{tray.name} {slot.name}")
                    out[tray.name][slot.name] = away_mm[nearest]
        return out

    def job(self, ports):
        """All kits by the kitting controller, on these ports instead of the cell's. Its report."""
        file, report = self.folder / "ports.json", self.folder / "report.json"
        own = json.loads(pathlib.Path(self.ours.ports_file).read_text(encoding="utf-8"))
        file.write_text(json.dumps(own | ports), encoding="utf-8")
        done = subprocess.run(
            [sys.executable, KITTING / "kitting", "--ports-file", file, "--report", report, "--move-limit", "900"],
            capture_output=True, text=True, timeout=180 * PATIENCE, check=False,
        )  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return json.loads(report.read_text(encoding="utf-8"))

    def move_belts(self, port):
        """The real belt by the registers, some centimetres; until ours has made that, too, and both stand."""
        with DeviceSocket(HOST, port, 60 * PATIENCE) as plc:
            for register, value in ((DIRECTION, 1), (SPEED, 3000), (RUN, 1)):
                write_register(plc, register, value)
            await_that(lambda: self.cell.snapshot().conveyor.speed_m_s > 0.029, "our belt runs")
            write_register(plc, RUN, 0)
        for cell in (self.real, self.cell):
            await_that(lambda: not cell.snapshot().conveyor.run and cell.snapshot().conveyor.speed_m_s == 0, "it stands")

    def agree(self):
        """Whether the Fanuc's table looks the same on both sides: what the camera's mirror achieves."""
        real, here = self.slots(self.real), self.slots(self.cell)
        return all(
            value is None if there is None else value is not None and value < MOVED_MM
            for kit in REAL_KITS
            for there, value in zip(real[kit].values(), here[kit].values(), strict=True)
        )

    def test_a_job_with_one_real_and_one_simulated_robot(self):
        process, ports = self.program()
        before_m = [cell.snapshot().conveyor.travel_m for cell in (self.real, self.cell)]
        self.move_belts(ports["modbus"])
        report = self.job(ports)
        self.assertTrue(report["complete"], report)
        for robot in ("fanuc", "motoman"):
            self.assertGreaterEqual(sum(kit["placed_by"].get(robot, 0) for kit in report["kits"]), 4, report)
        real, here = self.slots(self.real), self.slots(self.cell)
        for kits, slots in ((REAL_KITS, real), (SIMULATED_KITS, here)):
            for kit in kits:
                for slot, error_mm in slots[kit].items():
                    self.assertIsNotNone(error_mm, f"{slot} of {kit} is empty")
                    self.assertLess(error_mm, PLACED_MM, f"{slot} of {kit}")
        # The real side has none of the Motoman's work, the cell a copy of the Fanuc's.
        for kit in SIMULATED_KITS:
            self.assertEqual(set(real[kit].values()), {None}, kit)
        await_that(self.agree, lambda: f"{self.slots(self.cell)} {(self.folder / 'real.log').read_text()}")
        for cell, start_m in zip((self.real, self.cell), before_m, strict=True):
            self.assertGreater(cell.snapshot().conveyor.travel_m - start_m, 1e-3, "the belt has moved")
        process.terminate()
        self.assertEqual(process.wait(60 * PATIENCE), 0, (self.folder / "real.log").read_text())


def write_register(plc, register, value):
    """A holding register, and the answer."""
    plc.ask(HEADER.pack(1, 0, 6, 1) + struct.pack(">BHH", 6, register, value))
    plc.exactly(HEADER.size + 5)


if __name__ == "__main__":
    unittest.main()
