"""Trays and gears in drawn pictures, whose truth is known."""

import math
import unittest
from types import SimpleNamespace

from stack import cv2

import numpy as np
from drawing import Drawing, DrawnTray

from clients.vision.camera_map import from_description, from_values
from clients.vision.errors import VisionError
from clients.vision.gear_finder import Content, GearFinder
from clients.vision.prior import read_prior
from clients.vision.sight import Sight
from clients.vision.silhouette import Pose
from clients.vision.tray_finder import TrayFinder

PRIOR = read_prior("aprs_2025")
TABLE_MM = PRIOR.surfaces[0].top_mm
NAMES = tuple(PRIOR.cameras)


def camera_of(name):
    return PRIOR.cameras[name].map


def decoded(jpeg):
    return cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)


def tray_named(name):
    return next(kind for kind in PRIOR.trays if kind.name == name)


def error_of(tray, pose):
    """Distance [mm] and yaw [degrees] from the truth."""
    away = math.dist((tray.pose.x_mm, tray.pose.y_mm), (pose.x_mm, pose.y_mm))
    return away, abs(math.degrees(math.remainder(tray.pose.yaw - pose.yaw, math.tau)))


def random_layout(random, camera):
    """Trays that do not touch, all in the picture."""
    width, height = camera.size_px
    placed = []
    for _ in range(200):
        kind = PRIOR.trays[random.integers(len(PRIOR.trays))]
        pixel = np.array([[random.uniform(0, width), random.uniform(0, height)]])
        x, y = camera.points(pixel, TABLE_MM)[0, :2]
        pose = Pose(float(x), float(y), float(random.uniform(-math.pi, math.pi)))
        outline = pose.points(kind.outline_mm)
        seen = camera.pixels(np.column_stack([outline, np.full(len(outline), TABLE_MM)]))
        if (seen < 5).any() or (seen > np.array([width, height]) - 6).any():
            continue
        middle = outline.mean(axis=0)
        if all(math.dist(middle, other) > 285 for other, _ in placed):
            filled = tuple(slot.name for slot in kind.slots if random.random() < 0.5)
            label = int(random.integers(50))
            placed.append((middle, DrawnTray(kind, label, pose, filled)))
    return [drawn for _, drawn in placed]


class MapTest(unittest.TestCase):
    def test_pixels_and_points_of_a_plane_are_inverse(self):
        random = np.random.default_rng(1)
        for name in NAMES:
            camera = camera_of(name)
            pixels = random.uniform(0, camera.size_px, (1000, 2))
            for z in (0.0, TABLE_MM, TABLE_MM + 15):
                points = camera.points(pixels, z)
                np.testing.assert_allclose(points[:, 2], z, atol=1e-9)
                np.testing.assert_allclose(camera.pixels(points), pixels, atol=1e-6)

    def test_a_pinhole_is_the_closed_form(self):
        rows = [[1, 0, 0], [0, -1, 0], [0, 0, -1]]
        camera = from_values([640, 480], [800, 900], [320, 240], [], rows, [10, 20, 1000])
        np.testing.assert_allclose(
            camera.pixels(np.array([[110.0, 20, 0], [10, -70, 100]])), [[400, 240], [320, 330]], atol=1e-9
        )

    def test_a_distorted_pixel_is_the_closed_form(self):
        rows = [[1, 0, 0], [0, -1, 0], [0, 0, -1]]
        camera = from_values([640, 480], 1000, [320, 240], [-0.2], rows, [0, 0, 1000])
        r2 = 0.2**2
        np.testing.assert_allclose(
            camera.pixels(np.array([[200.0, 0, 0]])), [[320 + 200 * (1 - 0.2 * r2), 240]], atol=1e-9
        )

    def test_a_description_of_the_cell_gives_the_same_map(self):
        camera = camera_of("fanuc_table")
        X_WC = np.eye(4)
        X_WC[:3, :3], X_WC[:3, 3] = camera.R_CW.T, camera.place_mm / 1e3
        described = from_description(
            SimpleNamespace(
                size=camera.size_px, intrinsics=camera.intrinsics, distortion=camera.distortion, X_WC=X_WC
            )
        )
        points = np.array([[640.0, 550, 839], [900, 700, 854]])
        self.assertEqual(described.size_px, camera.size_px)
        np.testing.assert_allclose(described.pixels(points), camera.pixels(points), atol=1e-9)

    def test_rows_that_are_no_rotation_are_refused(self):
        with self.assertRaisesRegex(ValueError, "rotation"):
            from_values([640, 480], 800, [0, 0], [], [[1, 0, 0], [0, 1, 0], [0, 0, -1]], [0, 0, 0])
        with self.assertRaisesRegex(ValueError, "positive"):
            from_values([640, 480], 0, [0, 0], [], np.eye(3), [0, 0, 0])


class LayoutTest(unittest.TestCase):
    def check_layouts(self, name, seeds):
        camera = camera_of(name)
        trays, gears = TrayFinder(PRIOR, camera), GearFinder(PRIOR, camera)
        count, worst = 0, np.zeros(3)
        for seed in seeds:
            layout = random_layout(np.random.default_rng(seed), camera)
            drawing = Drawing(camera, TABLE_MM)
            for drawn in layout:
                drawing.tray(drawn)
            picture = decoded(drawing.finished(seed))
            found = trays.find(picture)
            view = gears.find(picture, found)
            self.assertEqual(len(found), len(layout), f"seed {seed}")
            self.assertEqual(view.loose, [], f"seed {seed}")
            for drawn in layout:
                here = (drawn.pose.x_mm, drawn.pose.y_mm)
                tray = min(found, key=lambda t: math.dist((t.pose.x_mm, t.pose.y_mm), here))
                what = f"seed {seed}, {drawn.type.name}"
                self.assertEqual((tray.type.name, tray.label), (drawn.type.name, drawn.label), what)
                away, turn = error_of(tray, drawn.pose)
                self.assertLess(away, 1.0, what)
                self.assertLess(turn, 0.5, what)
                count += 1
                worst = np.maximum(worst, [away, turn, 0])
                for slot in (s for s in view.slots if s.tray is tray):
                    filled = slot.slot.name in drawn.filled
                    self.assertEqual(
                        slot.content, Content.GEAR if filled else Content.EMPTY, f"{what} {slot.slot.name}"
                    )
                    if filled:
                        self.assertEqual(slot.gear.type, slot.slot.gear, what)
                        place = drawn.pose.points(np.array([slot.slot.xy_mm]))[0]
                        away = math.dist(place, (slot.gear.x_mm, slot.gear.y_mm))
                        self.assertLess(away, 1.0, f"{what} {slot.slot.name}")
                        worst[2] = max(worst[2], away)
        print(f"{name}: {count} trays, worst {worst[0]:.2f} mm, {worst[1]:.2f} degrees, gears {worst[2]:.2f} mm")
        self.assertGreater(count, len(seeds), "more than one tray a picture")

    def test_random_layouts_of_the_fanuc(self):
        self.check_layouts("fanuc_table", range(100, 112))

    def test_random_layouts_of_the_motoman(self):
        self.check_layouts("motoman_table", range(200, 216))


class SinglePictureTest(unittest.TestCase):
    def found(self, picture):
        camera = camera_of("motoman_table")
        trays = TrayFinder(PRIOR, camera).find(picture)
        return trays, GearFinder(PRIOR, camera).find(picture, trays).gears()

    def test_an_empty_table_shows_nothing(self):
        drawing = Drawing(camera_of("motoman_table"), TABLE_MM)
        self.assertEqual(self.found(decoded(drawing.finished(1))), ([], []))

    def test_noise_shows_nothing(self):
        random = np.random.default_rng(2)
        for kind in ("colours", "grey", "black"):
            noise = random.integers(0, 256, (960, 1280, 3), np.uint8)
            if kind == "grey":
                noise[:] = noise[:, :, :1]
            if kind == "black":
                noise[:] = 0
            self.assertEqual(self.found(noise), ([], []), kind)

    def test_a_label_without_a_tray_is_no_tray(self):
        camera = camera_of("motoman_table")
        drawing = Drawing(camera, TABLE_MM)
        drawing._label(DrawnTray(PRIOR.trays[0], 7, Pose(1400, 450, 0.3), ()), TABLE_MM)
        self.assertEqual(self.found(decoded(drawing.finished(3)))[0], [])

    def test_a_tray_beyond_the_edge_of_the_picture(self):
        """It is found while most of it is seen, and never as another type or in another place."""
        camera = camera_of("motoman_table")
        edge = camera.points(np.array([[0.0, 480.0]]), TABLE_MM)[0]
        found_at = {}
        for kind in PRIOR.trays:
            for beyond in (-130, -60, -40, -20, 0, 20, 60, 130):
                # The picture's left edge is at the greatest x.
                pose = Pose(float(edge[0]) + beyond, float(edge[1]), 0.4)
                drawing = Drawing(camera, TABLE_MM)
                drawing.tray(DrawnTray(kind, 9, pose, ()))
                trays, _ = self.found(decoded(drawing.finished(4)))
                found_at[kind.name, beyond] = bool(trays)
                for tray in trays:
                    away, turn = error_of(tray, pose)
                    self.assertEqual(tray.type.name, kind.name, beyond)
                    self.assertLess(away, 1.0, (kind.name, beyond))
                    self.assertLess(turn, 0.5, (kind.name, beyond))
        for kind in PRIOR.trays:
            self.assertTrue(found_at[kind.name, -130], kind.name)
            self.assertTrue(found_at[kind.name, -40], kind.name)
            self.assertFalse(found_at[kind.name, 60], kind.name)

    def test_without_the_heights_the_place_would_be_wrong(self):
        camera = camera_of("motoman_table")
        pose = Pose(1620.0, 650.0, 0.0)
        drawing = Drawing(camera, TABLE_MM)
        drawing.tray(DrawnTray(tray_named("sku_small_gear_vessel"), 3, pose, ()))
        picture = decoded(drawing.finished(5))
        finder = TrayFinder(PRIOR, camera)
        (label,) = finder._labels(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY))
        flat = camera.points(label.corners_px, TABLE_MM).mean(axis=0)
        self.assertGreater(math.dist(flat[:2], (pose.x_mm, pose.y_mm)), 2.0)
        (tray,) = finder.find(picture)
        self.assertLess(error_of(tray, pose)[0], 1.0)


class SightTest(unittest.TestCase):
    def test_objects_are_in_the_robots_frame(self):
        name = "motoman_table"
        camera = PRIOR.cameras[name]
        drawing = Drawing(camera.map, TABLE_MM)
        kind = tray_named("sku_kit_s2l2_vessel")
        drawing.tray(DrawnTray(kind, 5, Pose(1400.0, 400.0, math.pi), ("lg_1",)))
        tray, gear = Sight(PRIOR, camera, camera.map).objects(drawing.finished(6))
        # The base is at (1968.5, 150), turned by half.
        self.assertEqual((tray.name, tray.kind, gear.name, gear.kind), (kind.name, "KT", "sku_part_large_gear", "P"))
        self.assertAlmostEqual(tray.x_mm, 568.5, delta=1)
        self.assertAlmostEqual(tray.y_mm, -250, delta=1)
        self.assertAlmostEqual(tray.yaw, 0, delta=math.radians(0.5))
        self.assertAlmostEqual(gear.x_mm, 568.5 - 52, delta=1)
        self.assertAlmostEqual(gear.y_mm, -250 + 60, delta=1)

    def test_wrong_pictures_are_refused(self):
        camera = PRIOR.cameras["motoman_table"]
        sight = Sight(PRIOR, camera, camera.map)
        with self.assertRaisesRegex(VisionError, "damaged"):
            sight.objects(b"no picture")
        small = cv2.imencode(".jpg", np.zeros((48, 64, 3), np.uint8))[1].tobytes()
        with self.assertRaisesRegex(VisionError, "64 x 48 pixels, where 1280 x 960"):
            sight.objects(small)


if __name__ == "__main__":
    unittest.main()
