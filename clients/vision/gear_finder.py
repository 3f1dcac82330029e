"""Finds gears by their colours, and says what each slot holds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import cv2
import numpy as np

from .camera_map import Array, CameraMap
from .prior import GearType, Prior, Slot
from .silhouette import lifted
from .tray_finder import Tray

_COLOURED = 22  # least difference between the colours of a pixel of a gear [1/255]
_SATURATED = 0.2  # its least share of the brightest colour
_OCCUPIED = 0.6  # least share of coloured pixels of a seated gear's face
_HUE = 18.0  # farthest hue of a gear [degrees]
_MARGIN_MM = 2.0  # about a gear
_ROUND = 0.72  # least share of a loose gear's pixels in its circle
_SIZES = (0.7, 1.3)  # of a loose gear's area, as shares of its type's
_CIRCLE = np.linspace(0, math.tau, 48, endpoint=False)
_UNIT = np.column_stack([np.cos(_CIRCLE), np.sin(_CIRCLE)])


class Content(Enum):
    EMPTY = "empty"
    GEAR = "gear"
    UNKNOWN = "unknown"  # not in the picture


@dataclass(frozen=True)
class Gear:
    type: GearType
    x_mm: float
    y_mm: float
    score: float


@dataclass(frozen=True)
class SlotView:
    tray: Tray
    slot: Slot
    content: Content
    gear: Gear | None


@dataclass(frozen=True)
class GearView:
    slots: list[SlotView]
    loose: list[Gear]  # not seated

    def gears(self) -> list[Gear]:
        return [view.gear for view in self.slots if view.gear is not None] + self.loose


class GearFinder:
    def __init__(self, prior: Prior, camera: CameraMap) -> None:
        self._prior, self._map = prior, camera

    def find(self, picture: Array, trays: list[Tray]) -> GearView:
        """Gears of a picture (blue, green, red) in which these trays were found."""
        brightest = cv2.max(cv2.max(picture[:, :, 0], picture[:, :, 1]), picture[:, :, 2])
        darkest = cv2.min(cv2.min(picture[:, :, 0], picture[:, :, 1]), picture[:, :, 2])
        colour = brightest - darkest
        coloured = ((colour >= _COLOURED) & (colour >= _SATURATED * brightest)).astype(np.uint8)
        coloured *= 255
        hues = cv2.cvtColor(picture, cv2.COLOR_BGR2HSV_FULL)[:, :, 0].astype(float) * (360 / 256)
        slots = [
            self._slot(tray, slot, coloured, hues) for tray in trays for slot in tray.type.slots
        ]
        rest = coloured.copy()
        for view in slots:
            if view.gear is not None:
                z = view.tray.top_mm + view.gear.type.disc_mm / 2
                centre = np.array([view.gear.x_mm, view.gear.y_mm])
                circle = self._circle(centre, view.gear.type.radius_mm + 2 * _MARGIN_MM, z)
                cv2.fillPoly(rest, [circle], 0)
        return GearView(slots, self._loose(rest, hues, trays))

    def _slot(self, tray: Tray, slot: Slot, coloured: Array, hues: Array) -> SlotView:
        kind = slot.gear
        z = tray.top_mm + kind.disc_mm / 2
        centre = tray.pose.points(np.array([slot.xy_mm]))[0]
        face = self._circle(centre, 0.75 * kind.radius_mm, z)
        width, height = self._map.size_px
        if (face < 0).any() or (face[:, 0] >= width).any() or (face[:, 1] >= height).any():
            return SlotView(tray, slot, Content.UNKNOWN, None)
        share, hue = self._colour(face, coloured, hues)
        seen = self._seated_type(hue, centre, z, coloured) if share >= _OCCUPIED else None
        if seen is None:
            return SlotView(tray, slot, Content.EMPTY, None)
        # A gear as large as the slot's, whatever its colour says, is centred by its own size.
        x, y = self._centred(centre, seen.radius_mm, z, coloured)
        return SlotView(tray, slot, Content.GEAR, Gear(seen, x, y, min(share, 1.0)))

    def _seated_type(self, hue: float, centre: Array, z_mm: float, coloured: Array) -> GearType | None:
        """The type with about this hue whose size is nearest to the gear's. Bright pictures move hues
        towards each other."""
        kinds = self._types_of(hue)
        if not kinds:
            return None
        radius = max(kind.radius_mm for kind in kinds)
        window, _ = self._within(centre, radius, z_mm, coloured)
        area = cv2.countNonZero(window)
        return min(kinds, key=lambda kind: abs(math.log(self._size(kind, area, centre, z_mm))))

    def _within(
        self, centre: Array, radius_mm: float, z_mm: float, coloured: Array
    ) -> tuple[Array, tuple[int, int]]:
        """The coloured pixels of a circle and a margin, in a window, and the window's corner."""
        circle = self._circle(centre, radius_mm + _MARGIN_MM, z_mm)
        x, y, w, h = cv2.boundingRect(circle)
        x0, y0 = max(x, 0), max(y, 0)
        window = coloured[y0 : y + h, x0 : x + w]
        inside = np.zeros_like(window)
        cv2.fillPoly(inside, [circle - np.array([x0, y0], np.int32)], 255)
        return window & inside, (x0, y0)

    def _size(self, kind: GearType, area_px: float, place: Array, z_mm: float) -> float:
        """An area as share of a type's."""
        scale = self._map.px_per_mm(np.array([place[0], place[1], z_mm]))
        return max(area_px, 1.0) / (math.pi * (kind.radius_mm * scale) ** 2)

    def _centred(self, start: Array, radius_mm: float, z_mm: float, coloured: Array) -> Array:
        """Centre of the coloured pixels within a circle that follows them. The peg leaves no hole."""
        centre = start
        for _ in range(3):
            window, (x0, y0) = self._within(centre, radius_mm, z_mm, coloured)
            outlines, _ = cv2.findContours(window, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
            if not outlines:
                return start
            filled = np.zeros_like(window)
            cv2.drawContours(filled, [max(outlines, key=cv2.contourArea)], -1, 255, cv2.FILLED)
            rows, columns = np.nonzero(filled)
            pixel = np.array([[columns.mean() + x0, rows.mean() + y0]])
            centre = self._map.points(pixel, z_mm)[0, :2]
        return centre

    def _loose(self, rest: Array, hues: Array, trays: list[Tray]) -> list[Gear]:
        outlines, _ = cv2.findContours(rest, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        found = []
        for outline in outlines:
            area = cv2.contourArea(outline)
            if area < 100:
                continue
            moments = cv2.moments(outline)
            pixel = np.array([[moments["m10"], moments["m01"]]]) / moments["m00"]
            _, radius = cv2.minEnclosingCircle(outline)
            if area < _ROUND * math.pi * radius**2:
                continue
            fits = []
            for kind in self._types_of(self._colour(outline.reshape(-1, 2), rest, hues)[1]):
                place = self._lying(pixel, kind, trays)
                size = 0.0 if place is None else self._size(kind, area, place, float(place[2]))
                if place is not None and _SIZES[0] <= size <= _SIZES[1]:
                    gear = Gear(kind, float(place[0]), float(place[1]), min(size, 1.0))
                    fits.append((abs(math.log(size)), gear))
            if fits:
                found.append(min(fits, key=lambda fit: fit[0])[1])
        return found

    def _lying(self, pixel: Array, kind: GearType, trays: list[Tray]) -> Array | None:
        """The place of a gear that lies on a tray, or else with its hub on a surface."""
        for tray in trays:
            point: Array = self._map.points(pixel, tray.top_mm + kind.disc_mm)[0]
            outline = tray.pose.points(tray.type.outline_mm).astype(np.float32)
            at = (float(point[0]), float(point[1]))
            if cv2.pointPolygonTest(outline.reshape(-1, 1, 2), at, False) >= 0:
                return point
        for surface in self._prior.surfaces:
            point = self._map.points(pixel, surface.top_mm + kind.hub_mm + kind.disc_mm / 2)[0]
            if self._prior.surface_at(point[:2]) is surface:
                return point
        return None

    def _circle(self, centre: Array, radius_mm: float, z_mm: float) -> Array:
        pixels = self._map.pixels(lifted(centre + radius_mm * _UNIT, z_mm))
        return np.clip(np.rint(pixels), -(1 << 15), 1 << 15).astype(np.int32)

    def _colour(self, polygon: Array, coloured: Array, hues: Array) -> tuple[float, float]:
        """The coloured share of a polygon, and the median hue of these pixels [degrees]."""
        x, y, w, h = cv2.boundingRect(polygon)
        inside = np.zeros((h, w), np.uint8)
        cv2.fillPoly(inside, [polygon - np.array([x, y], np.int32)], 255)
        window = coloured[y : y + h, x : x + w]
        seen = (inside > 0) & (window > 0)
        if not seen.any():
            return 0.0, 0.0
        share = np.count_nonzero(seen) / np.count_nonzero(inside)
        return share, float(np.median(hues[y : y + h, x : x + w][seen]))

    def _types_of(self, hue: float) -> list[GearType]:
        return [k for k in self._prior.gears if abs((k.hue - hue + 180) % 360 - 180) <= _HUE]
