"""Maps pixels to points on planes of the world and back: a pinhole with the distortion of Brown (1966) in
OpenCV's terms. The camera frame has x to the right of the picture, y down, z along the view. Millimetres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

_UNDISTORT = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-12)


@dataclass(frozen=True)
class CameraMap:
    size_px: tuple[int, int]  # width, height
    intrinsics: Array  # 3 x 3
    distortion: Array  # k1, k2, p1, p2, k3
    R_CW: Array  # world to camera
    place_mm: Array  # of the camera in the world

    def pixels(self, points_mm: Array) -> Array:
        """Pixels (n, 2) of points of the world (n, 3)."""
        rotation, _ = cv2.Rodrigues(self.R_CW)
        shift = -self.R_CW @ self.place_mm
        found, _ = cv2.projectPoints(
            np.ascontiguousarray(points_mm, dtype=np.float64),
            rotation,
            shift,
            self.intrinsics,
            self.distortion,
        )
        pixels: Array = found.reshape(-1, 2)
        return pixels

    def points(self, pixels: Array, z_mm: float) -> Array:
        """Points (n, 3) of the horizontal plane at this height that pixels (n, 2) show."""
        flat = cv2.undistortPointsIter(
            np.ascontiguousarray(pixels, dtype=np.float64).reshape(-1, 1, 2),
            self.intrinsics,
            self.distortion,
            np.eye(3),
            np.eye(3),
            _UNDISTORT,
        ).reshape(-1, 2)
        rays = np.column_stack([flat, np.ones(len(flat))]) @ self.R_CW
        points: Array = self.place_mm + rays * ((z_mm - self.place_mm[2]) / rays[:, 2])[:, None]
        return points

    def px_per_mm(self, point_mm: Array) -> float:
        """Scale of the picture about a point of the world."""
        near = np.array([point_mm, point_mm + [1.0, 0, 0], point_mm + [0, 1.0, 0]])
        at = self.pixels(near)
        return float(np.hypot(*(at[1:] - at[0]).T).mean())


def from_values(
    size_px: Any, focal_px: Any, centre_px: Any, distortion: Any, rows: Any, place_mm: Any
) -> CameraMap:
    """A map from fitted numbers. The rows of the rotation may be rounded: the nearest rotation counts.
    Raises ValueError."""
    fx, fy = np.broadcast_to(np.asarray(focal_px, float), 2)
    cx, cy = np.asarray(centre_px, float)
    terms = np.zeros(5)
    terms[: len(distortion)] = distortion
    left, stretch, right = np.linalg.svd(np.asarray(rows, float).reshape(3, 3))
    rotation = left @ right
    if abs(stretch - 1).max() > 1e-3 or np.linalg.det(rotation) < 0:
        raise ValueError("the rows of a rotation are expected")
    width, height = (int(n) for n in size_px)
    if min(width, height) < 1 or min(fx, fy) <= 0:
        raise ValueError("positive sizes and focal lengths are expected")
    return CameraMap(
        (width, height),
        np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]]),
        terms,
        rotation,
        np.asarray(place_mm, float).reshape(3),
    )


def from_description(camera: Any) -> CameraMap:
    """The map of a camera of the Python package: its size, intrinsics, distortion and X_WC in metres."""
    X_WC = np.asarray(camera.X_WC, float)
    width, height = camera.size
    return CameraMap(
        (int(width), int(height)),
        np.asarray(camera.intrinsics, float),
        np.asarray(camera.distortion, float),
        X_WC[:3, :3].T.copy(),
        X_WC[:3, 3] * 1e3,
    )
