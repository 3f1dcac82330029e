"""One recorded episode, and the numbers of its states."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ..poses import quaternion
from ..snapshots import Snapshot

Observations = dict[str, npt.NDArray[Any]]
_BODY_NAMES = ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")


@dataclass
class Episode:
    """An episode of n steps. Lists of n entries belong to the steps; lists of n + 1 entries begin with the
    state after the reset."""

    seed: int
    options: dict[str, Any] = field(default_factory=dict)
    """The options of the reset."""
    states: list[npt.NDArray[np.float64]] = field(default_factory=list)
    """Before each step, the numbers of `state_names`."""
    actions: list[npt.NDArray[np.float32]] = field(default_factory=list)
    rewards: list[float] = field(default_factory=list)
    dones: list[bool] = field(default_factory=list)
    """The episode is over: terminated or truncated."""
    observations: list[Observations] = field(default_factory=list)
    """n + 1 observations by their names: `state`, and `image` of environments with pictures."""
    state_hashes: list[int] = field(default_factory=list)
    """n + 1 hashes of the bits of the cell's state."""
    sim_times_s: list[float] = field(default_factory=list)
    """n + 1 simulated times."""
    is_success: bool = False

    def __len__(self) -> int:
        return len(self.actions)


def state_names(snapshot: Snapshot) -> list[str]:
    """Names and units of the numbers of `state_numbers`."""
    names: list[str] = []
    for name, robot in snapshot.robots.items():
        joints = range(1, len(robot.joints_rad) + 1)
        names += [f"{name}.joint_{number}_rad" for number in joints]
        names += [f"{name}.joint_{number}_rad_s" for number in joints]
        names.append(f"{name}.separation_m")
    for name in snapshot.bodies:
        names += [f"{name}.{part}" for part in _BODY_NAMES]
    return names


def state_numbers(snapshot: Snapshot) -> npt.NDArray[np.float64]:
    """Joints and openings of the robots, poses of the bodies in the world."""
    parts: list[npt.ArrayLike] = []
    for robot in snapshot.robots.values():
        parts += [robot.joints_rad, robot.joint_velocities_rad_s, [robot.separation_m]]
    for body in snapshot.bodies.values():
        pose = body.pose
        parts += [pose[:3, 3], quaternion(pose[:3, :3])]
    return np.concatenate([np.asarray(part, dtype=np.float64) for part in parts])
