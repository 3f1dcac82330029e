"""Finds trays: a label gives the place, the outline gives type and pose. The silhouette of a tray is computed
at its true heights, so that parallax needs no correction afterwards."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterator

import cv2
import numpy as np

from .camera_map import Array, CameraMap
from .prior import Prior, TrayType
from .silhouette import Pose, find_edges, lifted, prism_silhouette, sample_polygon

_SAMPLES = 240
_CONTRAST = 25.0  # between tray and table [1/255]
_REACHES_MM = (8.0, 5.0, 3.0, 3.0)  # of the search, one a pass
_CLOSE_MM = 1.5  # an edge nearer than this to the silhouette supports it
_ACCEPTED = 0.6  # least share of supporting edges among those in the picture
_VISIBLE = 0.45  # least share of the silhouette in the picture
_LABEL_MM, _LABEL_RAD = 1.0, math.radians(1.0)  # accuracy of the label's pose
_SAME_MM = 20.0  # trays nearer than this are one
_FINE_PX_PER_MM = 1.2  # below it labels are sought in an enlarged picture
_ENLARGED = 3.0


@dataclass(frozen=True)
class Label:
    number: int
    corners_px: Array  # (4, 2): the upper left one first, clockwise


@dataclass(frozen=True)
class Tray:
    type: TrayType
    label: int
    pose: Pose
    low_mm: float  # height of its underside in the world
    score: float  # share of its silhouette's edges that were found

    @property
    def top_mm(self) -> float:
        return self.low_mm + self.type.thickness_mm


class TrayFinder:
    def __init__(self, prior: Prior, camera: CameraMap) -> None:
        self._prior, self._map = prior, camera
        self._dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_50)
        self._parameters = cv2.aruco.DetectorParameters_create()
        self._parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        self._parameters.cornerRefinementWinSize = 3
        self._parameters.minMarkerPerimeterRate = 0.02
        middle = np.array([s for s in camera.size_px], float) / 2
        centre = camera.points(middle[None], prior.surfaces[0].top_mm)[0]
        self._enlarged = _ENLARGED if camera.px_per_mm(centre) < _FINE_PX_PER_MM else 1.0

    def find(self, picture: Array) -> list[Tray]:
        """Trays of a picture (blue, green, red), those with more support first."""
        grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
        smooth = cv2.GaussianBlur(grey, (3, 3), 0).astype(np.float32)
        found: list[Tray] = []
        for label in self._labels(grey):
            trays = [tray for tray in self._hypotheses(label, smooth) if tray.score >= _ACCEPTED]
            if trays:
                found.append(max(trays, key=lambda tray: tray.score))
        found.sort(key=lambda tray: -tray.score)
        kept: list[Tray] = []
        for tray in found:
            if all(
                math.dist((tray.pose.x_mm, tray.pose.y_mm), (k.pose.x_mm, k.pose.y_mm)) > _SAME_MM
                for k in kept
            ):
                kept.append(tray)
        return kept

    def _labels(self, grey: Array) -> list[Label]:
        k = self._enlarged
        if k != 1:
            grey = cv2.resize(grey, None, fx=k, fy=k, interpolation=cv2.INTER_CUBIC)
        corners, numbers, _ = cv2.aruco.detectMarkers(
            grey, self._dictionary, parameters=self._parameters
        )
        if numbers is None:
            return []
        # The middles of the corner pixels coincide only at their outer edges.
        return [
            Label(int(n), (c.reshape(4, 2).astype(float) + 0.5) / k - 0.5)
            for n, c in zip(numbers.ravel(), corners)
        ]

    def _hypotheses(self, label: Label, smooth: Array) -> Iterator[Tray]:
        for kind in self._prior.trays:
            # The surface below decides on the height, and that on the place.
            for surface in self._prior.surfaces:
                top = surface.top_mm + kind.thickness_mm
                start = self._pose_of(label, kind, top - self._prior.label_depth_mm)
                if self._prior.surface_at(np.array([start.x_mm, start.y_mm])) is surface:
                    yield self._fit(kind, label.number, start, surface.top_mm, smooth)

    def _pose_of(self, label: Label, kind: TrayType, z_mm: float) -> Pose:
        corners = self._map.points(label.corners_px, z_mm)[:, :2]
        along = corners[1] + corners[2] - corners[0] - corners[3]
        yaw = math.atan2(along[1], along[0])
        x, y = corners.mean(axis=0) - Pose(0, 0, yaw).points(np.array([kind.label_mm]))[0]
        return Pose(float(x), float(y), yaw)

    def _fit(self, kind: TrayType, number: int, start: Pose, low_mm: float, smooth: Array) -> Tray:
        """Gauss-Newton steps on the distances between silhouette and edges along the normals, with the
        label's pose as a further measurement."""
        pose = start
        for reach_mm in _REACHES_MM:
            tray = Tray(kind, number, pose, low_mm, 0.0)
            step = self._step(tray, start, reach_mm, smooth)
            if step is None:
                return tray
            pose = Pose(pose.x_mm + step[0], pose.y_mm + step[1], pose.yaw + step[2])
        tray = Tray(kind, number, pose, low_mm, 0.0)
        return Tray(kind, number, pose, low_mm, self._support(tray, smooth))

    def _support(self, tray: Tray, smooth: Array) -> float:
        samples = sample_polygon(self._silhouette(tray), _SAMPLES)
        scale = self._scale(tray)
        edges = find_edges(smooth, samples, _CLOSE_MM * scale, _CONTRAST)
        visible = np.count_nonzero(edges.inside)
        if visible < _VISIBLE * _SAMPLES:
            return 0.0
        return np.count_nonzero(edges.found) / visible

    def _step(self, tray: Tray, start: Pose, reach_mm: float, smooth: Array) -> Array | None:
        samples = sample_polygon(self._silhouette(tray), _SAMPLES)
        scale = self._scale(tray)
        edges = find_edges(smooth, samples, reach_mm * scale, _CONTRAST)
        good = edges.found
        if np.count_nonzero(good) < _SAMPLES // 8:
            return None
        slopes = self._slopes(tray, samples.at[good], samples.normals[good])
        offsets = edges.offsets[good]
        # Tukey's weights: edges of gears and shadows beside the tray do not count.
        middle = np.median(abs(offsets)) + 0.3
        weights = np.clip(1 - (offsets / (4.0 * middle)) ** 2, 0, None)
        label = np.array([start.x_mm - tray.pose.x_mm, start.y_mm - tray.pose.y_mm, 0.0])
        label[2] = math.remainder(start.yaw - tray.pose.yaw, math.tau)
        accuracy = np.array([_LABEL_MM, _LABEL_MM, _LABEL_RAD])
        rows = np.vstack([slopes * weights[:, None], np.diag(1 / accuracy)])
        values = np.concatenate([offsets * weights, label / accuracy])
        step: Array = np.linalg.lstsq(rows, values, rcond=None)[0]
        return step

    def _slopes(self, tray: Tray, at: Array, normals: Array) -> Array:
        """Motion of the samples along their normals [px], for a motion of the tray by 1 mm in x and y and
        by 1 rad."""
        points = self._map.points(at, tray.top_mm)
        here = self._map.pixels(points)
        slopes = []
        arm = points[:, :2] - [tray.pose.x_mm, tray.pose.y_mm]
        turned = 1e-3 * np.column_stack([-arm[:, 1], arm[:, 0]])
        motions = ((np.array([1.0, 0.0]), 1.0), (np.array([0.0, 1.0]), 1.0), (turned, 1e-3))
        for shift, unit in motions:
            there = self._map.pixels(lifted(points[:, :2] + shift, tray.top_mm))
            slopes.append(((there - here) * normals).sum(axis=1) / unit)
        return np.column_stack(slopes)

    def _silhouette(self, tray: Tray) -> Array:
        outline = tray.pose.points(tray.type.outline_mm)
        return prism_silhouette(self._map, outline, tray.low_mm, tray.top_mm)

    def _scale(self, tray: Tray) -> float:
        return self._map.px_per_mm(np.array([tray.pose.x_mm, tray.pose.y_mm, tray.top_mm]))
