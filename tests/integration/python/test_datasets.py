"""Data sets: the layout of the file, the replay to the last bit, broken files, and the program."""

import contextlib
import io
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import numpy as np
from aprsim import BadArgument, datasets
from aprsim.datasets import DatasetError, __main__ as program
from running_cell import PATIENCE, ROOT

try:
    import h5py
except ImportError:
    h5py = None

NEEDS_H5PY = unittest.skipUnless(h5py, "h5py is not installed (Debian: python3-h5py)")
DOCUMENT = ROOT / "docs" / "python.md"
COMMAND = "python3 -m aprsim.datasets "


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_program(self, *arguments):
        """The exit code, the output and the errors of the program."""
        out, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
            code = program.main([str(argument) for argument in arguments])
        return code, out.getvalue(), errors.getvalue()


class WithoutLibrary(InFolder):
    def test_the_error_names_the_package(self):
        with mock.patch.dict(sys.modules, {"h5py": None}):
            for call in (
                lambda: datasets.record(self.folder / "new.hdf5"),
                lambda: datasets.replay(self.folder / "new.hdf5"),
            ):
                with self.assertRaisesRegex(DatasetError, "needs h5py, .*python3-h5py"):
                    call()
            code, _, errors = self.run_program("record", self.folder / "new.hdf5")
            self.assertEqual((code, "python3-h5py" in errors), (2, True))


@NEEDS_H5PY
class Layout(InFolder):
    """One recording, which the tests read and change copies of."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.recorded = pathlib.Path(folder.name) / "pick.hdf5"
        cls.successes = datasets.record(cls.recorded, "aprsim/Pick-v0", episodes=2, seed=4)

    def changed(self, change):
        """A copy in which `change` has changed something."""
        copy = self.folder / "copy.hdf5"
        shutil.copy(self.recorded, copy)
        with h5py.File(copy, "r+") as file:
            change(file)
        return copy

    def test_groups_and_shapes(self):
        self.assertEqual(self.successes, 2)
        self.assertEqual(os.listdir(self.recorded.parent), ["pick.hdf5"], "no part is left")
        with h5py.File(self.recorded) as file:
            data = file["data"]
            self.assertEqual(list(data), ["demo_0", "demo_1"])
            self.assertEqual(
                json.loads(data.attrs["env_args"]),
                {"env_name": "aprsim/Pick-v0", "type": 2, "env_kwargs": {}},
            )
            self.assertEqual(data.attrs["total"], sum(data[name].attrs["num_samples"] for name in data))
            for number, name in enumerate(data):
                demo = data[name]
                n = int(demo.attrs["num_samples"])
                self.assertEqual(demo.attrs["seed"], 4 + number)
                self.assertEqual(demo["states"].shape, (n, len(file["state_names"])))
                self.assertEqual(demo["actions"].shape, (n, 5))
                self.assertLessEqual(np.abs(demo["actions"]).max(), 1)
                self.assertEqual(demo["dones"][()].tolist(), [0] * (n - 1) + [1])
                self.assertEqual(demo["obs/state"].shape, (n, 10))
                np.testing.assert_array_equal(demo["obs/state"][1:], demo["next_obs/state"][:-1])
                self.assertEqual(len(demo["state_hashes"]), n + 1)
                self.assertTrue((np.diff(demo["sim_times_s"]) > 0).all())
                self.assertGreater(demo["rewards"][()].sum(), 1)
            names = list(file["state_names"].asstr())
            travel = dict(zip(names, np.ptp(data["demo_0/states"], axis=0)))
            self.assertGreater(travel["fanuc.joint_2_rad"], 0.01, "the arm has moved")
            self.assertGreater(travel["fanuc.separation_m"], 0.005, "the gripper")
            self.assertEqual(travel["motoman.joint_2_rad"], 0)
            self.assertNotIn("", names)

    def test_replays_to_the_last_bit(self):
        done = list(datasets.replay_all(self.recorded))
        self.assertEqual([(one.episode, one.is_same) for one in done], [(0, True), (1, True)])

        def other_hash_and_action(file):
            file["data/demo_0/state_hashes"][3] += np.uint64(1)
            file["data/demo_1/actions"][1, 2] += np.float32(0.001)

        code, out, _ = self.run_program("replay", self.changed(other_hash_and_action))
        self.assertEqual(code, 1)
        self.assertEqual(
            out.splitlines(),
            [f"episode {i}: the state after step {step} differs" for i, step in ((0, 3), (1, 2))],
        )

        def other_scene(file):
            del file["scene"]
            file["scene"] = "seed: 2"

        with self.assertRaisesRegex(DatasetError, "the scene has changed"):
            datasets.replay(self.changed(other_scene))

    def test_broken_files(self):
        def without(part):
            return lambda file: file.__delitem__(part)

        def attribute(group, name, value):
            return lambda file: file[group].attrs.__setitem__(name, value)

        def numbers(part, values):
            def change(file):
                del file[part]
                file[part] = values

            return change

        for words, change in {
            "data: missing": without("data"),
            "aprsim_format: 9, where 1": attribute("/", "aprsim_format", 9),
            "data: env_args: Expecting": attribute("data", "env_args", "{"),
            "data: env_args: no JSON object": attribute("data", "env_args", "[]"),
            "data: env_args: .*'env_name': 3": attribute("data", "env_args", '{"env_name": 3}'),
            "actions: missing": without("data/demo_0/actions"),
            "state_hashes: int64 of shape": numbers("data/demo_0/state_hashes", np.arange(3)),
            "actions: float32 of shape .2,.": numbers("data/demo_0/actions", np.zeros(2, np.float32)),
            "state_hashes: 1 for": numbers("data/demo_0/state_hashes", np.zeros(1, np.uint64)),
            "seed: -3": attribute("data/demo_0", "seed", -3),
            "scene: ": numbers("scene", np.zeros(3)),
            "where one of aprsim/BeltPick-v0": attribute(
                "data", "env_args", '{"env_name": "x", "env_kwargs": {}}'
            ),
            "aprsim/Pick-v0: .*colour": attribute(
                "data", "env_args", '{"env_name": "aprsim/Pick-v0", "env_kwargs": {"colour": 1}}'
            ),
        }.items():
            with self.subTest(words), self.assertRaisesRegex((DatasetError, BadArgument), words):
                datasets.replay(self.changed(change))
        text = self.folder / "text.hdf5"
        text.write_text("no HDF5", encoding="utf-8")
        for file in (text, self.folder / "none.hdf5"):
            with self.assertRaisesRegex(DatasetError, str(file)):
                datasets.replay(file)
        with self.assertRaisesRegex(BadArgument, "episode: 2, where a whole number from 0 to 1"):
            datasets.replay(self.recorded, 2)

    def test_what_cannot_be_recorded_leaves_no_file(self):
        file = self.folder / "new.hdf5"
        for words, arguments in {
            "policy: 'clever'": {"policy": "clever"},
            "episodes: 0": {"episodes": 0},
            "7 finite numbers": {"action": "joint_velocity"},
            "cell: ": {"cell": object()},
        }.items():
            with self.subTest(words), self.assertRaisesRegex(BadArgument, words):
                datasets.record(file, **{"episodes": 1, **arguments})
        with self.assertRaisesRegex(DatasetError, "the file exists already"):
            datasets.record(self.recorded)
        self.assertEqual(os.listdir(self.folder), [])


@NEEDS_H5PY
class Program(InFolder):
    def test_records_pictures_of_random_actions(self):
        file = self.folder / "pick.hdf5"
        code, out, errors = self.run_program(
            "record", file, "--episodes", 1, "--seed", 7, "--policy", "random", "--images",
            "--image-scale", 16, "--max-steps", 2,
        )
        self.assertEqual(code, 0, errors)
        self.assertIn("episode 0: seed 7, 2 steps, no success", out)
        with h5py.File(file) as recorded:
            pictures = recorded["data/demo_0/obs/image"]
            self.assertEqual((pictures.dtype, pictures.ndim, pictures.shape[3]), (np.uint8, 4, 3))
            self.assertGreater(np.ptp(pictures), 50, "it shows something")
            self.assertEqual(recorded["data/demo_0/obs/state"].shape, (2, 10))
        code, out, errors = self.run_program("replay", file, "--episode", 0)
        self.assertEqual((code, out), (0, "episode 0: 3 states are the same\n"), errors)
        code, _, errors = self.run_program("record", file, "--episodes", 1)
        self.assertEqual((code, "exists already" in errors), (2, True))

    def test_the_documented_lines(self):
        text = DOCUMENT.read_text(encoding="utf-8")
        lines = [line[4:] for line in text.splitlines() if line.startswith(f"    {COMMAND}")]
        self.assertEqual([line[len(COMMAND) :].split()[0] for line in lines], ["record", "replay"])
        for line in lines:
            words = [sys.executable, *line.split()[1:]]
            done = subprocess.run(
                words, cwd=self.folder, capture_output=True, text=True, timeout=200 * PATIENCE
            )
            self.assertEqual(done.returncode, 0, f"{line}: {done.stderr}")


if __name__ == "__main__":
    unittest.main()
