"""The outline of an upright prism in a picture, and the edges of a picture about it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from .camera_map import Array, CameraMap

Mask = npt.NDArray[np.bool_]

_LEVEL = 0.35  # of the rise from dark to bright at which an edge lies


@dataclass(frozen=True)
class Pose:
    """The pose of a tray's frame in the world; yaw in radians."""

    x_mm: float
    y_mm: float
    yaw: float

    def points(self, local_mm: Array) -> Array:
        """Points (n, 2) of the tray's frame in the world."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        points: Array = local_mm @ np.array([[c, s], [-s, c]]) + [self.x_mm, self.y_mm]
        return points


@dataclass(frozen=True)
class Samples:
    """Points along a silhouette, with normals away from it [px]."""

    at: Array  # (n, 2)
    normals: Array  # (n, 2)


@dataclass(frozen=True)
class Edges:
    """Edges found along the normals of samples."""

    offsets: Array  # from the sample outwards [px]
    found: Mask  # (n,)
    inside: Mask  # (n,): the sample's profile is in the picture


def lifted(points: Array, z_mm: float) -> Array:
    return np.column_stack([points, np.full(len(points), z_mm)])


def prism_silhouette(camera: CameraMap, outline: Array, low_mm: float, high_mm: float) -> Array:
    """The silhouette (n, 2) [px] of a prism over a convex outline (m, 2) of the world: the convex hull of
    what its ends show."""
    ends = camera.pixels(np.vstack([lifted(outline, low_mm), lifted(outline, high_mm)]))
    hull: Array = cv2.convexHull(ends.astype(np.float32)).reshape(-1, 2).astype(float)
    return hull


def sample_polygon(polygon: Array, count: int) -> Samples:
    """Points at equal distances along a convex polygon."""
    sides = np.roll(polygon, -1, axis=0) - polygon
    lengths = np.hypot(*sides.T)
    ends = np.cumsum(lengths)
    along = (np.arange(count) + 0.5) * ends[-1] / count
    side = np.searchsorted(ends, along)
    share = (along - (ends[side] - lengths[side])) / lengths[side]
    at = polygon[side] + sides[side] * share[:, None]
    normals = np.column_stack([sides[side][:, 1], -sides[side][:, 0]]) / lengths[side][:, None]
    outwards = np.sign(((at - polygon.mean(axis=0)) * normals).sum(axis=1).sum())
    return Samples(at, normals * outwards)


def find_edges(brightness: Array, samples: Samples, reach_px: float, contrast: float) -> Edges:
    """The steepest rise from dark to bright along each normal, within the reach, to a fraction of a pixel.
    An edge counts if the sides differ by the contrast."""
    step, side = 0.5, 2.0
    t = np.arange(-reach_px - side, reach_px + side + step, step)
    places = samples.at[:, None, :] + samples.normals[:, None, :] * t[None, :, None]
    height, width = brightness.shape
    inside = (
        (places >= 1).all(axis=(1, 2))
        & (places[..., 0] <= width - 2).all(axis=1)
        & (places[..., 1] <= height - 2).all(axis=1)
    )
    profile = cv2.remap(
        brightness,
        places[..., 0].astype(np.float32),
        places[..., 1].astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    ).astype(float)
    half = round(side / step)
    rise = profile[:, 2 * half :] - profile[:, : -2 * half]  # over twice the side
    best = rise.argmax(axis=1) + half  # in the profile
    top = rise.max(axis=1)
    crossing = _first_crossing(profile, best, half)
    return Edges(t[0] + step * crossing, (top >= contrast) & inside, inside)


def _first_crossing(profile: Array, best: Array, half: int) -> Array:
    """Index, with its fraction, at which each profile leaves the dark side about its steepest rise. The
    level is nearer to the dark side than to the bright one: a shadow between them is not yet crossed at
    its far end."""
    rows = np.arange(len(profile))
    low, high = profile[rows, best - half], profile[rows, best + half]
    level = low + _LEVEL * (high - low)
    columns = best[:, None] + np.arange(-half, half + 1)
    values = profile[rows[:, None], columns] - level[:, None]
    first = np.maximum((values >= 0).argmax(axis=1), 1)
    before, after = values[rows, first - 1], values[rows, first]
    share = np.where(after > before, -before / np.maximum(after - before, 1e-9), 0.0)
    crossing: Array = best - half + first - 1 + np.clip(share, 0, 1)
    return crossing
