"""A camera fitted to a map from points of a table to pixels: known cameras, the program, and the maps of the
laboratory where they are at hand."""

import contextlib
import io
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from aprsim import BadArgument, camera_fit
from aprsim.binaries import find_binary
from aprsim.camera_fit import FittedCamera, fit_camera, read_map

REFERENCE = os.environ.get("APRSIM_REFERENCE_DIR", "")
PITCH_M = 0.0254 / 30
ORIGIN_M = (1.0414, 0.381, 0.839)
SIZE_PX = (1920, 1080)


def turned(x_deg, y_deg, z_deg):
    """Rz Ry Rx, as rpy_deg in a scene."""
    out = np.eye(3)
    for axis, angle in ((2, z_deg), (1, y_deg), (0, x_deg)):
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        R = np.eye(3)
        i, j = [(1, 2), (2, 0), (0, 1)][axis]
        R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
        out = out @ R
    return out


def known_camera(tilt_deg=20.0, distortion=(-0.18, 0.05, 0.001), centre=(959.5, 539.5), size_px=SIZE_PX):
    X_WC = np.eye(4)
    X_WC[:3, :3] = turned(180 - tilt_deg, 1.0, -179.5)
    X_WC[:3, 3] = [0.75, 0.64 - 1.5 * np.tan(np.radians(tilt_deg)), 2.339]
    return FittedCamera(size_px, 2600.0, centre, distortion, X_WC)


def map_of(camera, rows=601, columns=661, crop=(0, 0)):
    """map_x and map_y of a table whose columns run along -x and rows along +y."""
    row, column = np.mgrid[0:rows, 0:columns]
    points = np.column_stack(
        [
            ORIGIN_M[0] - PITCH_M * column.ravel(),
            ORIGIN_M[1] + PITCH_M * row.ravel(),
            np.full(row.size, ORIGIN_M[2]),
        ]
    )
    pixels = camera.pixels(points) - crop
    return [pixels[:, i].reshape(row.shape).astype(np.float32) for i in range(2)]


class FitTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.file = self.folder / "map.npz"

    def read(self, **options):
        given = {"size_px": SIZE_PX, "origin_m": ORIGIN_M, "columns": "-x", "rows": "+y"}
        return read_map(self.file, **(given | options))

    def save(self, camera, crop=(314, 84), **more):
        x, y = map_of(camera, crop=crop)
        np.savez(self.file, map_x=x, map_y=y, crop_start=np.array(crop), **more)

    def assert_same_camera(self, found, known, pixels=0.01):
        place = np.abs(found.X_WC[:3, 3] - known.X_WC[:3, 3]).max()
        self.assertLess(place, 2e-4)
        self.assertLess(np.abs(found.X_WC[:3, :3] - known.X_WC[:3, :3]).max(), 1e-4)
        self.assertAlmostEqual(found.focal_px, known.focal_px, delta=0.2)
        np.testing.assert_allclose(found.centre_px, known.centre_px, atol=0.2)
        np.testing.assert_allclose(found.distortion, known.distortion, atol=2e-3)
        self.assertLess(found.rms_px, pixels)

    def test_known_cameras_are_found(self):
        for tilt, terms in ((20.0, 3), (35.0, 1), (5.0, 1)):
            with self.subTest(tilt=tilt, terms=terms):
                known = known_camera(tilt, (-0.18, 0.05, 0.001)[:terms])
                self.save(known)
                points, pixels = self.read()
                self.assertEqual(len(points), 21 * 23)
                self.assert_same_camera(fit_camera(points, pixels, SIZE_PX, terms=terms), known)

    def test_the_principal_point_is_found(self):
        known = known_camera(35.0, (-0.18,), centre=(930.0, 560.0))
        self.save(known)
        found = fit_camera(*self.read(), SIZE_PX, terms=1, fit_centre=True)
        self.assert_same_camera(found, known)

    def test_a_known_focal_length_is_kept(self):
        self.save(known_camera(3.0, (-0.18,)))
        found = fit_camera(*self.read(), SIZE_PX, focal_px=2600.0)
        self.assertEqual(found.focal_px, 2600.0)
        self.assertAlmostEqual(found.X_WC[2, 3], 2.339, delta=2e-4)

    def test_noise_of_the_map_is_the_residual(self):
        known = known_camera(20.0, (-0.18,))
        self.save(known)
        points, pixels = self.read()
        pixels = pixels + np.random.default_rng(1).normal(0, 0.5, pixels.shape)
        found = fit_camera(points, pixels, SIZE_PX)
        self.assertAlmostEqual(found.rms_px, 0.5 * 2**0.5, delta=0.05)
        self.assertLess(np.hypot(*(found.pixels(points) - known.pixels(points)).T).max(), 0.3)

    def test_a_rotated_frame_is_rotated_back(self):
        angle = 90.0
        known = known_camera(10.0, (-0.18,), centre=(639.5, 639.5), size_px=(1280, 1280))
        middle, R = np.array([640.0, 640.0]), np.array([[0.0, 1.0], [-1.0, 0.0]])
        x, y = map_of(known)
        # cv2.getRotationMatrix2D(middle, 90, 1): (x, y) goes to (y, -x) about the middle.
        rotated = (np.column_stack([x.ravel(), y.ravel()]) - middle) @ R.T + middle
        np.savez(self.file, map_x=rotated[:, 0].reshape(x.shape), map_y=rotated[:, 1].reshape(x.shape), angle=angle)
        points, pixels = self.read(size_px=(1280, 1280))
        np.testing.assert_allclose(pixels, known.pixels(points), atol=1e-3)

    def test_the_entry_is_the_camera(self):
        known = known_camera(20.0, (-0.18,))
        text = known.scene_entry("table")
        numbers = dict(re.findall(r"(\w+): \[?([^\]\n]+)", text))
        rpy = [float(n) for n in numbers["rpy_deg"].split(",")]
        np.testing.assert_allclose(turned(*rpy), known.X_WC[:3, :3], atol=2e-6)
        np.testing.assert_allclose([float(n) for n in numbers["xyz_m"].split(",")], known.X_WC[:3, 3], atol=1e-5)
        self.assertTrue(text.startswith("  - name: table\n"), text)

    def test_wrong_maps_and_numbers_are_named(self):
        x, y = map_of(known_camera())
        for arrays, text in (
            ({"map_x": x}, "no array map_y"),
            ({"map_x": x, "map_y": y[:-1]}, "two tables of a size"),
            ({"map_x": x, "map_y": y * np.nan}, "numbers are expected"),
            ({"map_x": x, "map_y": y, "crop_start": np.zeros(3)}, "crop_start"),
        ):
            with self.subTest(text=text):
                np.savez(self.file, **arrays)
                with self.assertRaisesRegex(BadArgument, text):
                    self.read()
        self.file.write_bytes(b"no archive")
        with self.assertRaisesRegex(BadArgument, "map.npz"):
            self.read()
        with self.assertRaisesRegex(BadArgument, "columns, rows"):
            self.read(columns="+y")
        points, pixels = np.zeros((20, 3)), np.zeros((20, 2))
        with self.assertRaisesRegex(BadArgument, "not in line"):
            fit_camera(points, pixels, SIZE_PX)
        with self.assertRaisesRegex(BadArgument, "at least 12"):
            fit_camera(points[:5], pixels[:5], SIZE_PX)
        with self.assertRaisesRegex(BadArgument, "terms"):
            fit_camera(points, pixels, SIZE_PX, terms=6)

    def test_the_program(self):
        self.save(known_camera(20.0, (-0.18,)))
        place = ["--size", "1920", "1080", "--origin-m", *map(str, ORIGIN_M), "--columns=-x", "--name", "table"]
        out, errors = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
            self.assertEqual(camera_fit.main([str(self.file), *place]), 0)
            self.assertEqual(camera_fit.main([str(self.folder / "none.npz"), *place]), 2)
        self.assertIn("483 points, 0.00 px rms", out.getvalue())
        self.assertIn("- name: table\n", out.getvalue())
        self.assertIn("distortion: [-0.18000]", out.getvalue())
        self.assertIn("none.npz", errors.getvalue())

    def test_the_command(self):
        self.save(known_camera(20.0, (-0.18,)))
        place = ["--size", "1920", "1080", "--origin-m", *map(str, ORIGIN_M), "--columns=-x", "--centre"]
        run = [find_binary("aprsim"), "camera", "fit"]
        # The interpreter of this test, which has numpy.
        path = f"{pathlib.Path(sys.executable).parent}:{os.environ['PATH']}"
        options = {"capture_output": True, "text": True, "env": {**os.environ, "PATH": path}}
        done = subprocess.run([*run, str(self.file), *place], **options)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("distortion: [-0.18000]", done.stdout)
        done = subprocess.run([*run, "none.npz", *place], **options)
        self.assertEqual(done.returncode, 2)
        self.assertIn("none.npz", done.stderr)


@unittest.skipUnless(REFERENCE, "no reference material: APRSIM_REFERENCE_DIR is not set")
class LaboratoryTest(unittest.TestCase):
    def test_the_cameras_of_the_laboratory(self):
        """Both published maps, within the noise of the holes that they come from; the scene has these cameras."""
        root = pathlib.Path(__file__).resolve().parents[3]
        scene = (root / "world" / "scenes" / "aprs_2025.yaml").read_text(encoding="utf-8")
        for name, size, origin, points_of_map in (
            ("fanuc_table", (1920, 1080), ORIGIN_M, 440),
            ("motoman_table", (1280, 960), (1.6764, 0.127, 0.839), 506),
        ):
            with self.subTest(name=name):
                file = pathlib.Path(REFERENCE, "aprs", "data", "vision_2025", f"{name}_calibration.npz")
                points, pixels = read_map(file, size_px=size, origin_m=origin, columns="-x", rows="+y")
                self.assertEqual(len(points), points_of_map)
                found = fit_camera(points, pixels, size)
                self.assertLess(found.rms_px, 0.6)
                self.assertLess(found.max_px, 2.0)
                entry = scene[scene.index(f"  - name: {name}\n") :]
                for key, value in (
                    ("xyz_m", found.X_WC[:3, 3]),
                    ("focal_px", [found.focal_px]),
                    ("distortion", found.distortion),
                ):
                    numbers = re.search(rf"^    {key}: \[?([^\]\n]+)", entry, re.M).group(1)
                    np.testing.assert_allclose([float(n) for n in numbers.split(",")], value, rtol=1e-3, err_msg=key)


if __name__ == "__main__":
    unittest.main()
