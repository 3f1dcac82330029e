"""The joints of a robot as its controller counts them by CRCL (`robots[].crcl_joints` of a scene)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Mapping, Sequence

import numpy as np
import yaml

from ...calls import robot_named
from ...cell import Cell
from ...errors import AprsimError
from ...poses import Array
from ..base.devices import DeviceLies


@dataclass(frozen=True)
class WireJoint:
    """One joint as it is counted."""

    joint: int
    """Index in the model; -1: a number that no joint has."""
    unit_rad: float = math.radians(1)
    sign: float = 1.0
    offset_rad: float = 0.0
    coupling: Mapping[int, float] = field(default_factory=dict)
    """Shares of the angles of other counted joints, from 0."""


class WireJoints:
    """All joints in the order of their CRCL numbers."""

    def __init__(self, joints: Sequence[WireJoint]) -> None:
        self._joints = joints
        self._count = 1 + max(joint.joint for joint in joints)

    @staticmethod
    def of_scene(text: str, robot: str, count: int) -> WireJoints:
        """Those of a robot with `count` joints in a scene's text."""
        tree = yaml.safe_load(text)
        entries = [one for one in tree.get("robots") or [] if one.get("name") == robot]
        if not entries:
            raise AprsimError(f"robot: the scene has no robot '{robot}'")
        listed = entries[0].get("crcl_joints")
        if not listed:
            return WireJoints([WireJoint(joint) for joint in range(count)])
        return WireJoints([_wire_joint(one) for one in listed])

    @staticmethod
    def of_cell(cell: Cell, robot: str) -> WireJoints:
        """Those of a robot of a running cell."""
        return WireJoints.of_scene(cell.scene_text(), robot, len(robot_named(cell.description, robot).joints))

    def positions_rad(self, values: Array) -> Array:
        """The model's joints for counted values, in degrees or counts of the drive. Raises DeviceLies."""
        if len(values) < len(self._joints) or not np.isfinite(values).all():
            raise DeviceLies(f"joints {values.tolist()}, where {len(self._joints)} finite numbers are expected")
        angles = [joint.unit_rad * value for joint, value in zip(self._joints, values)]
        out = np.zeros(self._count)
        for own, angle in zip(self._joints, angles):
            if own.joint >= 0:
                shares = sum(factor * angles[other] for other, factor in own.coupling.items())
                out[own.joint] = own.sign * angle + own.offset_rad + shares
        return out


def _wire_joint(entry: Mapping[str, Any]) -> WireJoint:
    joint = str(entry.get("joint", "none"))
    counts = entry.get("pulses_per_deg")
    return WireJoint(
        joint=-1 if joint == "none" else int(joint) - 1,
        unit_rad=math.radians(1 / float(counts) if counts else 1),
        sign=-1.0 if entry.get("reversed") else 1.0,
        offset_rad=math.radians(float(entry.get("offset_deg", 0))),
        coupling={int(number) - 1: float(factor) for number, factor in (entry.get("coupling") or {}).items()},
    )
