"""Trays and gears in the pictures of the running cell, against where they are: the layout of the laboratory
of 2025 with its cameras, moved and turned, gears in other slots; with outlines, and with boxes as trays."""

import json
import math
import pathlib
import re
import tempfile
import unittest

from stack import PATIENCE, ROOT, cv2

import numpy as np
from aprsim import Cell, Daemon

from clients.vision.gear_finder import Content, GearFinder
from clients.vision.mjpeg import MjpegReader
from clients.vision.prior import read_prior
from clients.vision.tray_finder import TrayFinder

CELLS = ROOT / "clients" / "vision" / "cells"
SCENES = ROOT / "world" / "scenes"
ROBOTS = {"fanuc_table": "fanuc", "motoman_table": "motoman"}
LAYOUTS = 2
FRESH = 4  # pictures of a new stream, after which none is older than the stream


def prior_of(folder, looks):
    text = (CELLS / "aprs_2025.toml").read_text()
    text = text.replace("../../kitting", str(ROOT / "clients" / "kitting"))
    text = text.replace('"looks_2025.toml"', f'"{CELLS / looks}"')
    path = folder / "cell.toml"
    path.write_text(text)
    return read_prior(str(path))


def rpy_deg(R):
    return [
        math.degrees(math.atan2(R[2, 1], R[2, 2])),
        math.degrees(-math.asin(R[2, 0])),
        math.degrees(math.atan2(R[1, 0], R[0, 0])),
    ]


def scene_with_cameras(folder, prior, trays):
    text = (SCENES / "aprs_2025.yaml").read_text()
    text = text.replace("types/trays_2025.yaml", f"types/{trays}")
    text = re.sub(r"^cameras:\n(?:[ #].*\n)*", "", text, flags=re.MULTILINE)
    text += "\ncameras:\n"
    for name, camera in prior.cameras.items():
        lens = camera.map
        values = {
            "name": name,
            "over": ROBOTS[name],
            "xyz_m": (lens.place_mm / 1e3).tolist(),
            "rpy_deg": rpy_deg(lens.R_CW.T),
            "resolution_px": list(lens.size_px),
            "focal_px": float(lens.intrinsics[0, 0]),
            "centre_px": lens.intrinsics[:2, 2].tolist(),
            "distortion": lens.distortion.tolist(),
            "noise": 2,
        }
        text += "  - {" + ", ".join(f"{key}: {value}" for key, value in values.items()) + "}\n"
    (folder / "types").symlink_to(SCENES / "types")
    path = folder / "scene.yaml"
    path.write_text(text)
    return path


def turned(centre, shift, yaw):
    """The motion of the world that turns about a point, then shifts."""
    c, s = math.cos(yaw), math.sin(yaw)
    X = np.eye(4)
    X[:2, :2] = [[c, -s], [s, c]]
    X[:2, 3] = centre + shift - X[:2, :2] @ centre
    return X


def yaw_of(X):
    return math.atan2(X[1, 0], X[0, 0])


class TrayTests:
    """The tests of one kind of trays: `looks` for the program, `scene` for the daemon."""

    @classmethod
    def setUpClass(cls):
        folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.prior = prior_of(folder, cls.looks)
        scene = cls.scene(folder)
        cls.daemon = Daemon(scene=str(scene), speed="stepped", start_s=60 * PATIENCE)
        cls.addClassCleanup(cls.daemon.close)
        cls.ports = json.loads(cls.daemon.ports_file.read_text())
        cls.cell = Cell.connect(cls.daemon.ports_file)
        cls.addClassCleanup(cls.cell.close)

    def picture(self, name):
        """A picture of the present, paused state, from the MJPEG stream."""
        port = self.ports[f"camera.{name}"]
        reader = MjpegReader(f"http://127.0.0.1:{port}/mjpg/video.mjpg")
        try:
            frame = reader.latest(FRESH - 1, 120 * PATIENCE)
            self.assertIsNotNone(frame, reader.trouble)
        finally:
            reader.close()
        return cv2.imdecode(np.frombuffer(frame.jpeg, np.uint8), cv2.IMREAD_COLOR)

    def gears_by_slot(self, bodies):
        """Name of the gear in each slot of each tray; the slots of the trays that have gears."""
        kinds = {kind.name: kind for kind in self.prior.trays}
        gears = [b for b in bodies.values() if "_gear_" in b.name and b.type not in kinds]
        seated = {}
        for body in bodies.values():
            for slot in kinds[body.type].slots if body.type in kinds else ():
                place = body.pose @ [slot.xy_mm[0] / 1e3, slot.xy_mm[1] / 1e3, 0, 1]
                near = [g.name for g in gears if math.dist(g.position_m[:2], place[:2]) < 3e-3]
                seated[body.name, slot.name] = near[0] if near else None
        return seated

    def lay_out(self, random):
        """Each tray is moved and turned a little, and its gears are in random slots that fit."""
        self.cell.reset()
        bodies = self.cell.snapshot(["bodies"]).bodies
        seated = self.gears_by_slot(bodies)
        kinds = {kind.name: kind for kind in self.prior.trays}
        moves = {}
        for tray in [b for b in bodies.values() if b.type in kinds]:
            shift = random.uniform(-0.008, 0.008, 2)
            X = turned(tray.position_m[:2], shift, math.radians(random.uniform(-5, 5)))
            moves[tray.name] = X @ tray.pose
            slots = kinds[tray.type].slots
            for gear_type in {slot.gear.name for slot in slots}:
                own = [slot for slot in slots if slot.gear.name == gear_type]
                gears = [g for s in own if (g := seated[tray.name, s.name])]
                for gear, index in zip(gears, random.permutation(len(own))):
                    place = moves[tray.name] @ [*np.array(own[index].xy_mm) / 1e3, 0.002, 1]
                    moves[gear] = bodies[gear].pose.copy()
                    moves[gear][:, 3] = place
        aside = np.eye(4)
        for i, name in enumerate(moves):  # makes room: an occupied place would move a body up
            aside[:3, 3] = [-0.4 - 0.3 * (i % 6), 1.8 + 0.3 * (i // 6), 0.2]
            self.cell.move_body(name, aside)
        for name, X in moves.items():
            self.cell.move_body(name, X)
        self.cell.step(1000)

    def test_poses_and_slots_are_those_of_the_cell(self):
        worst = np.zeros(3)
        count = 0
        for layout in range(LAYOUTS):
            self.lay_out(np.random.default_rng(layout))
            bodies = self.cell.snapshot(["bodies"]).bodies
            seated = self.gears_by_slot(bodies)
            for name, camera in self.prior.cameras.items():
                picture = self.picture(name)
                trays = TrayFinder(self.prior, camera.map).find(picture)
                slots = GearFinder(self.prior, camera.map).find(picture, trays).slots
                expected = [
                    b
                    for b in bodies.values()
                    if b.type in {t.name for t in self.prior.trays}
                    and camera.in_view(b.position_m[:2] * 1e3)
                ]
                self.assertGreater(len(expected), 2)
                for body in expected:
                    what = f"layout {layout}, {name}, {body.name}"
                    x, y = body.position_m[:2] * 1e3
                    tray = min(trays, key=lambda t: math.dist((t.pose.x_mm, t.pose.y_mm), (x, y)))
                    away = math.dist((tray.pose.x_mm, tray.pose.y_mm), (x, y))
                    turn = abs(
                        math.degrees(math.remainder(tray.pose.yaw - yaw_of(body.pose), math.tau))
                    )
                    self.assertEqual((tray.type.name, tray.label), (body.type, int(body.name[-2:])), what)
                    self.assertLess(away, 1.0, what)
                    self.assertLess(turn, 0.5, what)
                    count += 1
                    worst = np.maximum(worst, [away, turn, 0])
                    for view in (s for s in slots if s.tray is tray):
                        gear = seated[body.name, view.slot.name]
                        seen = Content.GEAR if gear else Content.EMPTY
                        self.assertEqual(view.content, seen, f"{what} {view.slot.name}")
                        if gear:
                            self.assertEqual(view.gear.type.name, bodies[gear].type, what)
                            at = bodies[gear].position_m[:2] * 1e3
                            away = math.dist(at, (view.gear.x_mm, view.gear.y_mm))
                            self.assertLess(away, 1.0, f"{what} {view.slot.name}")
                            worst[2] = max(worst[2], away)
        print(f"{count} trays, worst {worst[0]:.2f} mm, {worst[1]:.2f} degrees, gears {worst[2]:.2f} mm")


class OutlineTest(TrayTests, unittest.TestCase):
    """The scene as it is."""

    looks = "looks_2025.toml"

    @classmethod
    def scene(cls, folder):
        return "aprs_2025"


class BoxTest(TrayTests, unittest.TestCase):
    looks = "looks_2024.toml"

    @classmethod
    def scene(cls, folder):
        return scene_with_cameras(folder, cls.prior, "trays_2024.yaml")


if __name__ == "__main__":
    unittest.main()
