"""Parameters estimated from recordings: hidden ones recovered, intervals that cover them, what the data do
not tell; and a scene compared with recordings, by the command line."""

import json
import math
import os
import pathlib
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import numpy as np
import synthetic_recordings as synthetic
from modbus_requests import ask
from running_cell import PACKAGE, PATIENCE

from aprsim import BadArgument, Cell, Daemon, crcl
from aprsim.binaries import find_binary
from aprsim.calibration import estimates
from aprsim.calibration.belt_fit import fit_belt, speed_at, targets
from aprsim.calibration.calibrating import calibrate
from aprsim.calibration.carried_fit import fit_carried
from aprsim.calibration.comparing import compare
from aprsim.calibration.force_fit import find_presses, fit_force, free_samples
from aprsim.calibration.joint_fit import fit_joints
from aprsim.calibration.journals import records
from aprsim.calibration.line_fit import fit_camera
from aprsim.calibration.motion_fit import fit_robot
from aprsim.calibration.profiles import duration, rest_to_rest
from aprsim.calibration.recordings import RobotRecord, read_recording

FITS = {
    "robot": lambda one: fit_robot("fanuc", one, {}),
    "moves": lambda one: fit_joints("fanuc", one, synthetic.LIMITS_RAD_S, {}),
    "trajectories": lambda one: fit_joints("motoman", one, (), {}),
    "carried": lambda one: fit_carried("fanuc", *one, None, None),
    "belt": lambda one: fit_belt(one, {}),
    "camera": lambda one: fit_camera("fanuc", *one, {})[0],
    "force": lambda one: fit_force("fanuc", [one], {}),
}
CASES = {"robot": 5, "moves": 3, "trajectories": 3, "carried": 3, "belt": 8, "camera": 40, "force": 5}
NEAR_ZERO = ("bias", "drift")  # parameters whose relative error says nothing


class ProfileTest(unittest.TestCase):
    def test_profiles_go_from_rest_to_rest_within_their_limits(self):
        random = np.random.default_rng(1)
        for _ in range(200):
            way, speed, accel = random.uniform(1e-3, 1), random.uniform(0.01, 2), random.uniform(0.1, 20)
            ramp = random.choice([0.0, random.uniform(0.001, 0.3)])
            end = duration(way, speed, accel, ramp)
            time = np.linspace(-0.1, end + 0.1, 2001)
            s = rest_to_rest(time, way, speed, accel, ramp)
            step = time[1] - time[0]
            v = np.diff(s) / step
            self.assertTrue((np.abs(s[time <= 0]) < 1e-12).all())
            self.assertTrue((np.abs(s[time >= end] - way) < 1e-9).all())
            self.assertGreater(v.min(), -1e-9)
            self.assertLess(v.max(), speed * (1 + 1e-9))
            self.assertLess(np.abs(np.diff(v)).max() / step, accel * (1 + 1e-6))

    def test_a_belt_follows_its_settings_at_limited_acceleration(self):
        random = np.random.default_rng(2)
        for _ in range(50):
            record, hidden = synthetic.belt(random)
            gain, accel = hidden["conveyor.m_s_per_count"], hidden["conveyor.max_accel_m_s2"]
            decel = hidden["conveyor.max_decel_m_s2"]
            time = np.linspace(0, 32, 32001)
            v = speed_at(time, targets(record), gain, accel, decel, 0.1)
            change = np.diff(v) / 1e-3
            self.assertLess(change.max(), accel + 1e-6)
            self.assertGreater(change.min(), -decel - 1e-6)
            self.assertAlmostEqual(v[4400], gain * record.writes[0][2], delta=1e-9)
            self.assertAlmostEqual(v[8400], 0, delta=1e-9)


class EstimateTest(unittest.TestCase):
    def test_least_squares_give_the_intervals_of_the_linear_model(self):
        random = np.random.default_rng(3)
        hits = 0
        for _ in range(300):
            x = random.uniform(0, 1, 12)
            y = 2 + 3 * x + random.normal(0, 0.1, 12)
            found = estimates.fit(lambda p, x=x, y=y: p[0] + p[1] * x - y, [0, 0], [-10, -10], [10, 10])
            low, high = found.interval(1)
            hits += low <= 3 <= high
        self.assertTrue(0.92 <= hits / 300 <= 0.98, hits)

    def test_what_residuals_do_not_depend_on_is_not_told(self):
        t = np.linspace(0, 1, 20)
        found = estimates.fit(lambda p: p[0] + p[1] - t, [0.1, 0.1, 0.1], [-9] * 3, [9] * 3)
        for i in range(3):
            self.assertFalse(found.estimate(i, "p", "1").judged().is_told, i)
        sound = estimates.fit(lambda p: p[0] * t - t, [0.1], [-9], [9])
        self.assertTrue(sound.estimate(0, "p", "1").judged().is_told)

    def test_bootstrap_covers_a_median(self):
        random = np.random.default_rng(4)
        hits = sum(
            low <= 5 <= high
            for low, high in (
                estimates.bootstrap(lambda few: float(np.median(few)), list(random.normal(5, 1, 40)), 200, seed)
                for seed in range(100)
            )
        )
        self.assertGreaterEqual(hits, 88)
        self.assertFalse(math.isfinite(estimates.bootstrap(lambda few: 0.0, [1, 2, 3])[0]))


class HiddenParametersTest(unittest.TestCase):
    """Recordings of made-up cells; tests/benchmarks/calibration has 200 cases of each."""

    def test_they_are_recovered_and_covered(self):
        covered = told = 0
        for kind, count in CASES.items():
            for seed in range(count):
                record, hidden = getattr(synthetic, kind)(np.random.default_rng(1000 + seed))
                found = {one.name: one for one in FITS[kind](record)}
                for name, value in hidden.items():
                    one = found[name]
                    told += one.is_told
                    covered += one.is_told and one.low <= value <= one.high
                    if one.is_told and not any(word in name for word in (*NEAR_ZERO, "noise", "drop")):
                        error = abs(one.value - value) - 0.5 * (one.high - one.low)
                        self.assertLess(error, 0.05 * abs(value), f"{kind} {seed} {name}: {one.value}, hidden {value}")
        self.assertGreater(told, 340)
        self.assertTrue(0.91 <= covered / told <= 0.98, f"{covered} of {told}")

    def test_what_is_not_in_the_data_is_named_with_its_reason(self):
        for one in fit_robot("fanuc", RobotRecord(), {}):
            self.assertFalse(one.is_told, one)
            self.assertTrue(one.why_not)
        record, _ = synthetic.belt(np.random.default_rng(5))
        still = [one for one in record.readings if one[0] < 0.4]
        record.readings = still
        self.assertTrue(all("readings" in one.why_not or "still" in one.why_not for one in fit_belt(record, {})))
        log, _ = synthetic.force(np.random.default_rng(6))
        coarse = type(log)(log.time_s[::10], log.force_n[::10], log.tool_m[::10], log.command[::10], log.guard_n)
        found = {one.name: one for one in fit_force("fanuc", [coarse], {})}
        stiffness = found["robots.fanuc.gripper.palm_stiffness_n_m"]
        self.assertFalse(stiffness.is_told)
        self.assertTrue(found["robots.fanuc.force_sensor.noise_n"].is_told)

    def test_a_tray_that_does_not_slip_tells_the_latency_and_a_bound_of_its_friction(self):
        for seed in range(3):
            record, hidden = synthetic.carried(np.random.default_rng(3000 + seed), friction=0.8)
            latency, friction = fit_carried("fanuc", *record, None, None)
            self.assertAlmostEqual(latency.value, hidden[latency.name], delta=5e-3)
            self.assertFalse(friction.is_told)
            self.assertRegex(friction.why_not, r"no tray slips at .* at least 0\.\d")
        record[0].frames.clear()
        record[0].times_s.clear()
        self.assertEqual([one.is_told for one in fit_carried("fanuc", *record, None, None)], [False, False])

    def test_states_alone_tell_their_period_and_say_what_is_missing(self):
        record, _ = synthetic.moves(np.random.default_rng(7))
        record.points.clear()
        found = fit_joints("fanuc", record, synthetic.LIMITS_RAD_S, {})
        self.assertEqual([one.is_told for one in found], [True, False])
        self.assertIn("no point", found[1].why_not)

    def test_presses_are_found_in_a_log(self):
        for seed in range(10):
            log, _ = synthetic.force(np.random.default_rng(2000 + seed))
            presses = find_presses(log, free_samples(log))
            self.assertEqual(len(presses), 6)
            for one in presses:
                self.assertAlmostEqual(one.speed_m_s, 0.01, delta=2e-4)


class RecordingTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        return path

    def test_files_that_are_none_are_refused_with_their_name(self):
        for text in ("", "hello\n", "a,b,c\n1,2,3\n"):
            with self.assertRaisesRegex(BadArgument, "one.txt"):
                read_recording(self.write("one.txt", text), "fanuc")
        with self.assertRaisesRegex(BadArgument, "none.journal"):
            read_recording(self.folder / "none.journal", "fanuc")

    def test_columns_and_numbers_of_force_logs_are_checked(self):
        rows = "\n".join(f"{0.1 * i},1,0,0,{i},1,2,3" for i in range(12))
        log = read_recording(self.write("f.csv", "time_s,cmdid,fx,fy,fz,x,y,z\n" + rows), "fanuc").forces["fanuc"][0]
        self.assertEqual(log.force_n[3, 2], 3)
        self.assertAlmostEqual(log.tool_m[0, 2], 0.003)
        with self.assertRaisesRegex(BadArgument, "no column fx"):
            read_recording(self.write("f.csv", "time_s,cmdid,fy,fz,x,y,z\n" + rows), "fanuc")
        with self.assertRaisesRegex(BadArgument, "fz"):
            read_recording(self.write("f.csv", "time_s,cmdid,fx,fy,fz,x,y,z\n" + rows.replace(",5,", ",oh,")), "fanuc")

    def test_lines_of_a_camera(self):
        line = "sku_part_large_gear,0.10,536.51,47.32,0.89,P,sku_part_large_gear,,,,,P\n"
        camera = read_recording(self.write("lines.csv", line * 4), "fanuc").cameras["fanuc"]
        self.assertEqual(len(camera.frames), 4)
        self.assertAlmostEqual(camera.frames[0][0].x_m, 0.53651)
        self.assertTrue(math.isnan(camera.frames[0][1].x_m))


REFERENCE = os.environ.get("APRSIM_REFERENCE_DIR", "")


@unittest.skipUnless(REFERENCE, "no reference material: APRSIM_REFERENCE_DIR is not set")
class LaboratoryTest(unittest.TestCase):
    def test_the_force_test_of_the_laboratory(self):
        log = pathlib.Path(REFERENCE) / "aprs" / "data" / "lab_logs" / "fanucFTTestData.csv"
        found = {one.name.removeprefix("robots.fanuc."): one for one in calibrate([log], "aprs_lab").estimates}
        self.assertTrue(found["force_sensor.bias_n[2]"].contains(-35.4))
        self.assertAlmostEqual(found["force_sensor.noise_n"].value, 0.036, delta=0.005)
        # The robot went at 40 % of the commanded 20 mm/s.
        self.assertAlmostEqual(found["press_speed_m_s"].value, 0.008, delta=1e-4)
        self.assertTrue(0.05 < found["gripper.palm_relaxation.share"].value < 0.15)
        self.assertTrue(0.08 < found["guard_delay_s"].value < 0.15)
        # A sample or none in contact on the way down.
        self.assertFalse(found["gripper.palm_stiffness_n_m"].is_told)


class CellTest(unittest.TestCase):
    """A second cell, whose parameters calibrate does not know."""

    HIDDEN = """base: aprs
robot_types:
  fanuc_lrmate200id:
    limits: {trans_speed_m_s: 0.35, trans_accel_m_s2: 1.6}
    gripper: {finger_speed_m_s: 0.03}
conveyor: {max_speed_m_s: 0.2, max_accel_m_s2: 0.3, max_decel_m_s2: 0.2}
robots:
- name: fanuc
  vision: {position_noise_m: 0.0004, drop_rate: 0.05}
"""
    TRUE = {
        "robots.fanuc.limits.trans_speed_m_s": 0.35,
        "robots.fanuc.limits.trans_accel_m_s2": 1.6,
        "robots.fanuc.gripper.finger_speed_m_s": 0.03,
        "conveyor.max_speed_m_s": 0.2,
        "conveyor.max_accel_m_s2": 0.3,
        "conveyor.max_decel_m_s2": 0.2,
        "conveyor.m_s_per_count": 1e-5,
        "robots.fanuc.vision.position_noise_m": 4e-4,
    }

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.hidden = cls.folder / "hidden.yaml"
        cls.hidden.write_text(cls.HIDDEN, encoding="utf-8")
        cls.journal = cls.folder / "run.journal"
        options = ("--journal", str(cls.journal), "--no-web")
        with Daemon(*options, scene=str(cls.hidden), speed="stepped", start_s=60 * PATIENCE) as daemon:
            cls.work(daemon)

    @classmethod
    def work(cls, daemon):
        """A controller's session: moves, gripper, belt, camera."""
        ports = json.loads(pathlib.Path(daemon.ports_file).read_text(encoding="utf-8"))
        with (
            Cell.connect(daemon.ports_file) as cell,
            socket.create_connection(("127.0.0.1", ports["vision.fanuc"]), 30),
            socket.create_connection(("127.0.0.1", ports["modbus"]), 30) as modbus,
        ):
            robot = cell.robot("fanuc")
            robot.initialise()
            robot.run(status_report())
            robot.set_speed(1.0)
            for _ in range(3):
                for way in ([0, 0, -0.12], [0, 0, 0.12], [0.15, 0, 0], [-0.15, 0, 0]):
                    robot.move_by(way)
                robot.close_gripper()
                robot.dwell(0.8)
                robot.open_gripper()
                robot.dwell(0.8)
            for counts in (12000, 18000, 30000):
                ask(modbus, struct.pack(">BHH", 6, 0x8002, counts))
                for run, polls in ((1, 80), (0, 100)):
                    ask(modbus, struct.pack(">BHH", 6, 0x8000, run))
                    for _ in range(polls):
                        cell.step(20)
                        ask(modbus, struct.pack(">BHH", 4, 0x8000, 8))

    def test_hidden_parameters_are_recovered(self):
        found = {one.name: one for one in calibrate([self.journal], "aprs").estimates}
        for name, value in self.TRUE.items():
            # The number of frames that a camera's client gets depends on the machine.
            if "noise" in name and not found[name].is_told:
                continue
            self.assertTrue(found[name].is_told, f"{name}: {found[name].why_not}")
            slack = 0.5 * (found[name].high - found[name].low) if "noise" in name else 0
            self.assertLess(abs(found[name].value - value), 0.05 * value + slack, found[name])
        self.assertFalse(found["robots.fanuc.vision.latency_s"].is_told)
        self.assertTrue(found["robots.fanuc.vision.latency_s"].why_not)

    def test_the_overlay_makes_a_cell_that_moves_like_the_recorded_one(self):
        fitted = self.folder / "fitted.yaml"
        fitted.write_text(calibrate([self.journal], "aprs").overlay(), encoding="utf-8")
        before, after, same = (
            {f"{one.part} {one.quantity}": one.rms for one in compare(self.journal, scene).differences}
            for scene in ("aprs", str(fitted), str(self.hidden))
        )
        self.assertEqual(set(before), set(after))
        for name, rms in same.items():
            # A wire notes the latest step that its listener had seen, which may be some behind.
            self.assertLess(rms, max(0.2 * before[name], 1e-6), name)
        for name in ("fanuc tool x", "fanuc tool z", "belt speed"):
            self.assertLess(after[name], 0.2 * before[name], name)
            self.assertGreater(before[name], 1e-3)

    def run_program(self, *words):
        # The interpreter of this test, which has the packages.
        path = f"{pathlib.Path(sys.executable).parent}:{os.environ['PATH']}"
        environment = {**os.environ, "PYTHONPATH": str(PACKAGE), "PATH": path}
        return subprocess.run(
            [find_binary("aprsim"), *words], capture_output=True, text=True, env=environment, timeout=120 * PATIENCE
        )

    def test_the_command_line(self):
        out = self.folder / "by_command.yaml"
        done = self.run_program("calibrate", str(self.journal), "--scene", "aprs", "--out", str(out), "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        names = {one["name"] for one in json.loads(done.stdout)["estimates"]}
        self.assertLessEqual(set(self.TRUE), names)
        for limit, code in (("position_mm=0.01", 1), ("position_mm=100", 0)):
            done = self.run_program("compare", str(self.journal), "--scene", "aprs", "--limit", limit)
            self.assertEqual(done.returncode, code, done.stderr)
        self.assertEqual(self.run_program("compare", str(self.hidden), "--scene", "aprs").returncode, 2)
        wrong = self.run_program("compare", str(self.journal), "--scene", "aprs", "--limit", "speed=1")
        self.assertEqual(wrong.returncode, 2)
        self.assertIn("position_mm", wrong.stderr)

    def test_a_journal_that_was_cut_off_is_read_to_its_last_frame(self):
        whole = list(records(self.journal))
        cut = self.folder / "cut.journal"
        cut.write_bytes(self.journal.read_bytes()[: int(0.7 * self.journal.stat().st_size)])
        some = list(records(cut))
        self.assertTrue(0 < len(some) < len(whole))
        self.assertEqual([one.SerializeToString() for one in some], [one.SerializeToString() for one in whole[: len(some)]])


def status_report():
    """Every part of the status."""
    fields = []
    for part in ("JointStatuses", "PoseStatus", "GripperStatus", "SettingsStatus", "SensorsStatus", "GuardsStatus"):
        element = ElementTree.Element(f"Report{part}")
        element.text = "true"
        fields.append(element)
    return crcl.Command("ConfigureStatusReport", tuple(fields))


if __name__ == "__main__":
    unittest.main()
