"""Poses as numpy arrays. X_AB is the pose of frame B in frame A: a 4 x 4 matrix with the rotation in
[:3, :3] and the position in metres in [:3, 3]. It converts points of B to points of A:
p_A = X_AB @ p_B with p = (x, y, z, 1), and X_AC = X_AB @ X_BC.

| letter | frame |
|---|---|
| W | world |
| R | reference frame of a robot's CRCL poses |
| T | tool centre point of a robot |
| B, P | body: a gear (origin at the centre of its underside) or a tray (origin on its top) |"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from . import arguments
from .v1 import geometry_pb2

Array = npt.NDArray[np.float64]


def vector(message: geometry_pb2.Vector3) -> Array:
    """The three components of a message."""
    return np.array([message.x, message.y, message.z])


def matrix(pose: geometry_pb2.Pose) -> Array:
    """The 4 x 4 pose of a message. A quaternion of any length is accepted; zero means no rotation."""
    q = pose.orientation
    out = np.eye(4)
    out[:3, :3] = rotation(np.array([q.w, q.x, q.y, q.z]))
    out[:3, 3] = (pose.position_m.x, pose.position_m.y, pose.position_m.z)
    return out


def pose_message(pose: npt.ArrayLike) -> geometry_pb2.Pose:
    """The message of a 4 x 4 pose."""
    values = arguments.pose("pose", pose)
    w, x, y, z = (float(value) for value in quaternion(values[:3, :3]))
    px, py, pz = (float(value) for value in values[:3, 3])
    return geometry_pb2.Pose(
        position_m=geometry_pb2.Vector3(x=px, y=py, z=pz),
        orientation=geometry_pb2.Quaternion(w=w, x=x, y=y, z=z),
    )


def rotation(quaternion: Array) -> Array:
    """The 3 x 3 rotation of a quaternion (w, x, y, z)."""
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
    """The quaternion (w, x, y, z), w >= 0, of a 3 x 3 rotation: Shepperd's method, by the largest
    component."""
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
    """The inverse X_BA of a pose X_AB."""
    out = np.eye(4)
    out[:3, :3] = pose[:3, :3].T
    out[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return out


def tool_down(position: npt.ArrayLike, yaw: float = 0.0) -> Array:
    """The pose X_WT of a tool at `position` [m] that points straight down. `yaw` [rad] is the angle of
    its x axis about the vertical."""
    position_m = arguments.vector("position", position, 3, "m")
    angle = arguments.number("yaw", yaw, "rad")
    c, s = math.cos(angle), math.sin(angle)
    out = np.eye(4)
    out[:3, :3] = [[c, s, 0], [s, -c, 0], [0, 0, -1]]
    out[:3, 3] = position_m
    return out


def yaw_of(pose: Array) -> float:
    """The angle of the x axis about the vertical, in -pi .. pi [rad]."""
    return math.atan2(pose[1, 0], pose[0, 0])


def wrapped(angle: float) -> float:
    """The equivalent angle in -pi .. pi [rad]."""
    return math.remainder(angle, 2 * math.pi)
