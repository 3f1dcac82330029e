"""Draws trays with gears as a camera sees them, each edge where the lens shows it."""

from dataclasses import dataclass

import cv2
import numpy as np

from clients.vision.silhouette import Pose, lifted

SHIFT = 4  # fractional bits of drawn pixels
TABLE, SIDE, TOP, POCKET = (200, 205, 205), (26, 26, 28), (52, 50, 48), (22, 20, 19)
LABEL = (240, 244, 244)
MARKER_SIDE_MM, LABEL_SIDE_MM = 30.0, 40.0
SEAT_MM = 0.3  # of a seated gear above the tray


@dataclass(frozen=True)
class DrawnTray:
    type: object
    label: int
    pose: Pose
    filled: tuple  # names of the slots with a gear


class Drawing:
    def __init__(self, camera, table_mm):
        self.camera, self.table_mm = camera, table_mm
        width, height = camera.size_px
        self.picture = np.empty((height, width, 3), np.uint8)
        self.picture[:] = TABLE

    def tray(self, drawn):
        kind, top = drawn.type, self.table_mm + drawn.type.thickness_mm
        self._prism(drawn.pose.points(kind.outline_mm), self.table_mm, top, SIDE, TOP)
        for slot in kind.slots:
            self._face(drawn.pose.points(circle(slot.xy_mm, 0.8 * slot.gear.radius_mm)), top, POCKET)
        self._label(drawn, top - 1.0)
        for slot in kind.slots:
            if slot.name in drawn.filled:
                self._gear(drawn.pose, slot, top + SEAT_MM)

    def finished(self, seed, noise=2.0, quality=80):
        """The picture with blur, noise and the losses of JPEG, as bytes of the file."""
        picture = cv2.GaussianBlur(self.picture, (0, 0), 0.6).astype(float)
        picture += np.random.default_rng(seed).normal(0, noise, picture.shape)
        good, data = cv2.imencode(
            ".jpg", np.clip(picture, 0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, quality]
        )
        assert good
        return data.tobytes()

    def _gear(self, pose, slot, low):
        rim = pose.points(gear_rim(slot.xy_mm, slot.gear.radius_mm))
        hue = cv2.cvtColor(
            np.uint8([[[round(slot.gear.hue / 360 * 256), 200, 190]]]), cv2.COLOR_HSV2BGR_FULL
        )[0, 0]
        colour = tuple(int(v) for v in hue)
        self._prism(rim, low, low + slot.gear.disc_mm, tuple(v // 2 for v in colour), colour)
        peg = pose.points(circle(slot.xy_mm, 3.85))
        self._prism(peg, low + 6, low + 26, (90, 90, 90), (150, 150, 150))

    def _label(self, drawn, z):
        square = np.array([[-1, 1], [1, 1], [1, -1], [-1, -1]], float)
        centre = np.array(drawn.type.label_mm)
        paper = drawn.pose.points(centre + square * LABEL_SIDE_MM / 2)
        self._face(paper, z, LABEL)
        dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_50)
        side = 280
        marker = cv2.aruco.drawMarker(dictionary, drawn.label, side)
        corners = drawn.pose.points(centre + square * MARKER_SIDE_MM / 2)
        to = self.camera.pixels(lifted(corners, z)).astype(np.float32)
        e = side - 0.5
        at = np.float32([[-0.5, -0.5], [e, -0.5], [e, e], [-0.5, e]])
        turn = cv2.getPerspectiveTransform(at, to)
        size = (self.picture.shape[1], self.picture.shape[0])
        ink = cv2.warpPerspective(255 - marker, turn, size, flags=cv2.INTER_AREA) / 255.0
        dark = np.array([16.0, 16, 16])
        blended = self.picture * (1 - ink[..., None]) + dark * ink[..., None]
        self.picture[:] = np.rint(blended)

    def _prism(self, outline, low, high, side, top):
        ends = [self.camera.pixels(lifted(outline, z)) for z in (low, high)]
        n = len(outline)
        for i in range(n):
            j = (i + 1) % n
            self._fill(np.array([ends[0][i], ends[0][j], ends[1][j], ends[1][i]]), side)
        self._fill(ends[1], top)

    def _face(self, outline, z, colour):
        self._fill(self.camera.pixels(lifted(outline, z)), colour)

    def _fill(self, pixels, colour):
        if abs(pixels).max() < 1e5:
            points = np.rint(pixels * (1 << SHIFT)).astype(np.int32)
            cv2.fillPoly(self.picture, [points], colour, cv2.LINE_AA, SHIFT)


def circle(centre, radius, sides=64):
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    return np.array(centre) + radius * np.column_stack([np.cos(angle), np.sin(angle)])


def gear_rim(centre, radius):
    teeth = max(12, round(2 * np.pi * radius / 9))
    turn = np.add.outer(np.arange(teeth), [-0.28, -0.14, 0.14, 0.28]).ravel() / teeth * 2 * np.pi
    radii = np.tile([radius - 5, radius, radius, radius - 5], teeth)
    return np.array(centre) + radii[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
