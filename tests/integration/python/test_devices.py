"""Devices of extensions: the same bits in every program, replays, saved states and refusals."""

import json
import os
import pathlib
import subprocess
import tempfile
import time
import unittest

from aprsim import AprsimError, Cell, Daemon, World
from running_cell import PATIENCE, ROOT

BINARIES = pathlib.Path(os.environ["APRSIM_BIN_DIR"])
EXTENSIONS = BINARIES.parent / "extensions"
WEIGHING = str(ROOT / "clients" / "devices" / "weighing.yaml")


def daemon(*arguments, scene=WEIGHING, extensions=EXTENSIONS):
    given = ["--extensions", str(extensions)] if extensions else []
    return Daemon(
        "--no-web", *given, *arguments, scene=scene, speed="stepped", start_s=60 * PATIENCE
    )


def weigh(cell):
    """Carries the tray to the scale; hashes and readings on the way."""
    cell.set_conveyor(run=True, forward=True, speed_m_s=0.3)
    seen = []
    for _ in range(10):
        now = cell.step(500)
        scale = now.device("scale")
        seen.append((now.state_hash, scale.signals["mass_kg"], scale.signals["full"]))
    return seen


def aprsim(*arguments, extensions=None):
    environment = dict(os.environ, APRSIM_EXTENSIONS=str(extensions or ""))
    return subprocess.run(
        [BINARIES / "aprsim", *arguments], env=environment, capture_output=True, text=True
    )


class WithFiles(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.directory = pathlib.Path(directory.name)

    def scene(self, device):
        path = self.directory / "mine.yaml"
        path.write_text(f"base: empty_belt\ndevices:\n  - {device}\n")
        return str(path)


class WorldTest(WithFiles):
    """Devices in a cell of this process."""

    def test_the_same_bits_each_time(self):
        with World(WEIGHING, extensions=[EXTENSIONS]) as world:
            described = world.description.devices[0]
            self.assertEqual((described.name, described.extension), ("scale", "scale"))
            self.assertEqual(list(described.signals), ["mass_kg", "full"])
            first = weigh(world)
            world.reset()
            self.assertEqual(weigh(world), first)
            world.keep()
            later = world.step(200).state_hash
            world.go_back()
            self.assertEqual(world.step(200).state_hash, later)
        # The tray of 0.2 kg with two gears of 10.2 g has stopped the belt.
        self.assertAlmostEqual(first[-1][1], 0.2204, places=9)
        self.assertEqual([full for _, _, full in first][::9], [0, 1])

    def refusal(self, device):
        with self.assertRaises(AprsimError) as raised:
            World(self.scene(device), extensions=[EXTENSIONS])
        return str(raised.exception)

    def test_refusals_name_the_cause(self):
        missing = self.refusal("{name: s, extension: nothing}")
        self.assertIn("mine.yaml:3:26: devices[0].extension: device s: no libnothing.so", missing)
        self.assertIn("built for version 0", self.refusal("{name: s, extension: outdated}"))
        self.assertIn(
            "expected the name of an extension", self.refusal("{name: s, extension: ../libscale}")
        )
        parameter = self.refusal(
            "{name: s, extension: scale, parameters: {low_m: [0, 0, 0], high_m: [1, 1]}}"
        )
        self.assertIn("high_m: found a list of 2, expected a list of 3 numbers", parameter)
        thrown = self.refusal("{name: t, extension: trouble, parameters: {kind: constructor}}")
        self.assertIn("device t: no licence", thrown)

    def test_texts_from_elsewhere_name_known_extensions_only(self):
        with World(WEIGHING, extensions=[EXTENSIONS]) as world:
            before = world.step(10)
            for extension, text in {
                "nothing": "scene text:3:",
                "../../libscale": "expected the name of an extension",
                "text": "libtext.so cannot be loaded",
            }.items():
                sent = "base: empty_belt\ndevices:\n  - {name: s, extension: " + extension + "}\n"
                with self.assertRaises(AprsimError) as raised:
                    world.reset(scene_text=sent)
                self.assertIn(text, str(raised.exception))
                self.assertNotIn(str(EXTENSIONS), str(raised.exception))
            self.assertEqual(world.snapshot().state_hash, before.state_hash)
            mover = "{name: m, extension: mover, parameters: {action: none}}"
            world.reset(scene_text=f"base: empty_belt\ndevices:\n  - {mover}\n")
            self.assertIn("noise", world.step(1).device("m").signals)

    def test_a_failing_device_is_a_fault_and_the_cell_goes_on(self):
        scene = self.scene("{name: t, extension: trouble, parameters: {kind: throw, at_step: 50}}")
        with World(scene, extensions=[EXTENSIONS]) as world:
            self.assertEqual(world.step(50).device("t").fault, "")
            now = world.step(100)
            self.assertTrue(now.device("t").fault.startswith("step 50: broken "))
            self.assertEqual((now.step, now.world_fault), (150, ""))
            world.reset()
            self.assertEqual(world.step(1).device("t").fault, "")
            with self.assertRaises(AprsimError):
                world.snapshot().device("u")


class DaemonTest(WithFiles):
    """Devices in a daemon, its journals and its saved states."""

    def test_gives_the_bits_of_a_world(self):
        with daemon() as served, Cell.connect(served.ports_file) as cell:
            seen = weigh(cell)
            status = aprsim("status", "--ports-file", str(served.ports_file)).stdout
            self.assertRegex(status, r"devices\n  scale    mass_kg 0\.2204 full 1\n")
        with World(WEIGHING, extensions=[EXTENSIONS]) as world:
            self.assertEqual(weigh(world), seen)

    def test_replays_with_the_library_alone(self):
        journal = str(self.directory / "run.journal")
        with daemon("--journal", journal) as served, Cell.connect(served.ports_file) as cell:
            weigh(cell)
        replayed = aprsim("replay", journal, extensions=EXTENSIONS)
        self.assertIn("all states are the same", replayed.stdout, replayed.stderr)
        refused = aprsim("replay", journal)
        self.assertEqual(refused.returncode, 2, refused.stdout)
        self.assertIn("it cannot be replayed here: recorded scene:", refused.stderr)
        self.assertIn("device scale: no libscale.so", refused.stderr)
        # Another library of this name differs, or is said to be another one.
        (self.directory / "libscale.so").write_bytes(
            (EXTENSIONS / "libscale.so").read_bytes() + b"\0"
        )
        other = aprsim("replay", journal, extensions=self.directory)
        self.assertIn("the extension scale was recorded with the digest", other.stdout)

    def test_a_saved_state_goes_on_in_another_daemon(self):
        saved = str(self.directory / "weighing.state")
        with daemon() as served, Cell.connect(served.ports_file) as cell:
            cell.set_conveyor(run=True, forward=True, speed_m_s=0.3)
            cell.step(3100)
            done = aprsim("save", "here", "--file", saved, "--ports-file", str(served.ports_file))
            self.assertEqual(done.returncode, 0, done.stderr)
            there = cell.step(400)
        with daemon() as served, Cell.connect(served.ports_file) as cell:
            done = aprsim("load", "--file", saved, "--ports-file", str(served.ports_file))
            self.assertEqual(done.returncode, 0, done.stderr)
            here = cell.step(400)
            self.assertEqual(here.state_hash, there.state_hash)
            self.assertEqual(here.device("scale").signals, there.device("scale").signals)

    def test_inputs_are_set_by_every_client_and_replayed(self):
        pusher = (
            "{name: pusher, extension: pusher, parameters: {low_m: [-2, -1, 0.5], "
            "high_m: [2, 1, 1.5], along: [1, 0, 0], max_force_n: 2}}"
        )
        journal = str(self.directory / "run.journal")
        scene = self.scene(pusher)
        with (
            daemon("--journal", journal, scene=scene) as served,
            Cell.connect(served.ports_file) as cell,
        ):
            described = cell.description.devices[0].inputs[0]
            self.assertEqual((described.signal, described.max, described.unit), ("force_n", 2, "N"))
            start = cell.step(100).bodies["small_gear_vessel_1"].position_m[0]
            cell.set_signal("pusher", "force_n", 1.8)
            self.assertEqual(cell.step(200).device("pusher").signals["pushed"], 1)
            given = ["device", "set", "pusher", "force_n"]
            ports = ["--ports-file", str(served.ports_file)]
            done = aprsim(*given, "0.5", "--json", *ports)
            self.assertEqual(json.loads(done.stdout)["value"], 0.5, done.stderr)
            now = cell.step(100)
            self.assertEqual(now.device("pusher").signals["force_n"], 0.5)
            self.assertGreater(now.bodies["small_gear_vessel_1"].position_m[0], start + 1e-3)
            for arguments, text in {
                ("pusher", "force_n", 3): "force_n of pusher is 3 N, must be within 0 to 2 N",
                ("pusher", "pushed", 1): "signal 'pushed' of pusher is set by the device only",
                ("nobody", "on", 1): "no device is named 'nobody'; there are: pusher",
            }.items():
                with self.assertRaises(AprsimError) as raised:
                    cell.set_signal(*arguments)
                self.assertIn(text, str(raised.exception))
            refused = aprsim(*given, "3", *ports)
            self.assertNotEqual(refused.returncode, 0)
            self.assertIn("must be within 0 to 2 N", refused.stderr)
        replayed = aprsim("replay", journal, extensions=EXTENSIONS)
        self.assertIn("all states are the same", replayed.stdout, replayed.stderr)
        with World(scene, extensions=[EXTENSIONS]) as world:
            world.step(100)
            world.set_signal("pusher", "force_n", 1.8)
            world.step(200)
            world.set_signal("pusher", "force_n", 0.5)
            self.assertEqual(world.step(100).state_hash, now.state_hash)

    def test_missing_directories_and_libraries_are_refused(self):
        for extensions, text in {
            "/nowhere": "'/nowhere' is no directory",
            str(self.directory): "device scale: no libscale.so",
        }.items():
            with self.assertRaises(AprsimError) as raised:
                daemon(extensions=extensions)
            self.assertIn(text, str(raised.exception))

    def test_the_log_names_a_device_that_fails(self):
        scene = self.scene("{name: t, extension: trouble, parameters: {kind: throw, at_step: 50}}")
        with daemon(scene=scene) as served, Cell.connect(served.ports_file) as cell:
            self.assertTrue(cell.step(100).device("t").fault.startswith("step 50: broken "))
            deadline = time.monotonic() + 60 * PATIENCE
            while "device t has failed in step 50" not in served.log():
                self.assertLess(time.monotonic(), deadline, served.log())
                time.sleep(0.05)


if __name__ == "__main__":
    unittest.main()
