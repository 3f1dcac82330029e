"""Poses as numpy arrays: a pose of frame B in frame A is the 4 x 4 matrix X_AB that takes points of B
to points of A, in metres. Frames are ARCHITECTURE.md's: W world, R a robot's reference frame for CRCL
poses, T tool, P part."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from .errors import AprsimError
from .v1 import geometry_pb2

Array = npt.NDArray[np.float64]


def vector(message: geometry_pb2.Vector3) -> Array:
    """Three components."""
    return np.array([message.x, message.y, message.z])


def matrix(pose: geometry_pb2.Pose) -> Array:
    """4 x 4, of a pose message; its quaternion need not be of length 1, a null one is no turn."""
    q = pose.orientation
    out = np.eye(4)
    out[:3, :3] = rotation(np.array([q.w, q.x, q.y, q.z]))
    out[:3, 3] = (pose.position_m.x, pose.position_m.y, pose.position_m.z)
    return out


def pose_message(pose: npt.ArrayLike) -> geometry_pb2.Pose:
    """The message of a 4 x 4 pose."""
    values = np.asarray(pose, dtype=np.float64)
    if values.shape != (4, 4):
        raise AprsimError(f"pose: of shape {values.shape}, where (4, 4) is expected")
    w, x, y, z = (float(value) for value in quaternion(values[:3, :3]))
    px, py, pz = (float(value) for value in values[:3, 3])
    return geometry_pb2.Pose(
        position_m=geometry_pb2.Vector3(x=px, y=py, z=pz),
        orientation=geometry_pb2.Quaternion(w=w, x=x, y=y, z=z),
    )


def rotation(quaternion: Array) -> Array:
    """3 x 3, of (w, x, y, z)."""
    length = float(np.linalg.norm(quaternion))
    if length == 0.0:
        return np.eye(3)
    w, x, y, z = (float(value) for value in quaternion / length)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion(turn: Array) -> Array:
    """(w, x, y, z) with w >= 0, of a 3 x 3 rotation (Shepperd's method: by the largest component)."""
    t = np.asarray(turn, dtype=np.float64)
    squares = np.array(
        [
            1 + t[0, 0] + t[1, 1] + t[2, 2],
            1 + t[0, 0] - t[1, 1] - t[2, 2],
            1 - t[0, 0] + t[1, 1] - t[2, 2],
            1 - t[0, 0] - t[1, 1] + t[2, 2],
        ]
    )
    largest = int(np.argmax(squares))
    products = np.array(
        [
            [squares[0], t[2, 1] - t[1, 2], t[0, 2] - t[2, 0], t[1, 0] - t[0, 1]],
            [t[2, 1] - t[1, 2], squares[1], t[0, 1] + t[1, 0], t[0, 2] + t[2, 0]],
            [t[0, 2] - t[2, 0], t[0, 1] + t[1, 0], squares[2], t[1, 2] + t[2, 1]],
            [t[1, 0] - t[0, 1], t[0, 2] + t[2, 0], t[1, 2] + t[2, 1], squares[3]],
        ]
    )
    out: Array = products[largest] / (2 * math.sqrt(squares[largest]))
    return -out if out[0] < 0 else out


def inverse(pose: Array) -> Array:
    """X_BA of X_AB."""
    out = np.eye(4)
    out[:3, :3] = pose[:3, :3].T
    out[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return out


def tool_down(position: npt.ArrayLike, yaw: float = 0.0) -> Array:
    """A tool that points straight down at a point, its x axis turned by `yaw` [rad] about the
    vertical."""
    c, s = math.cos(yaw), math.sin(yaw)
    out = np.eye(4)
    out[:3, :3] = [[c, s, 0], [s, -c, 0], [0, 0, -1]]
    out[:3, 3] = np.asarray(position, dtype=np.float64)
    return out


def yaw_of(pose: Array) -> float:
    """Of the x axis about the vertical, in -pi .. pi [rad]."""
    return math.atan2(pose[1, 0], pose[0, 0])


def wrapped(angle: float) -> float:
    """The angle turned by whole turns into -pi .. pi [rad]."""
    return math.remainder(angle, 2 * math.pi)
