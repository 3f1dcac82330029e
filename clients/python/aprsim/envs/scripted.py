"""A policy that solves the tasks from their observations alone: an example, and a baseline for learned
policies."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from .. import arguments
from .actions import MOVE_M, TURN_RAD
from .spaces import Vector
from .transfer_state import NAMES

APPROACH_M = 0.06
"""Height above the place where a gear is grasped or released."""

_AT_M, _AT_RAD = 0.001, 0.01  # tolerance of an arrival
_CLEAR_M = 0.8 * APPROACH_M  # least height for a sideways motion
_DROP_M = 0.0005  # height above the slot at the release


def scripted_action(observation: npt.ArrayLike) -> Vector:
    """The next action: above the gear, down, close, up, above the slot, down, open. BadArgument where
    the observation is not the numbers of `transfer_state.NAMES`, as a picture is not."""
    values = arguments.vector("observation", observation, len(NAMES), "").tolist()
    gear, slot = values[0:3], values[3:6]
    turn, held = values[6], values[8] > 0.5
    if values[9] >= 1.0:
        return tool_action(0.0, 0.0, 0.0, 0.0, opened=True)  # all is done
    if held:
        height = -slot[2]
        if math.hypot(slot[0], slot[1]) > _AT_M:
            return tool_action(*_sideways(slot, height, APPROACH_M), 0.0, opened=False)
        at = height < _DROP_M + _AT_M
        return tool_action(slot[0], slot[1], _DROP_M - height, 0.0, opened=at)
    height = -gear[2]
    turned = abs(turn) > _AT_RAD
    if math.hypot(gear[0], gear[1]) > _AT_M or (turned and height > _AT_M):
        way = _sideways(gear, height, APPROACH_M)
        return tool_action(*way, turn if height > _CLEAR_M else 0.0, opened=True)
    at = height < _AT_M
    return tool_action(gear[0], gear[1], -height, 0.0, opened=not at)


def _sideways(to: list[float], height: float, wanted: float) -> tuple[float, float, float]:
    """Move up first: neighbours are lower than that height."""
    if height < _CLEAR_M and math.hypot(to[0], to[1]) > 3 * _AT_M:
        return 0.0, 0.0, wanted - height
    return to[0], to[1], max(0.0, wanted - height) if height < _CLEAR_M else wanted - height


def tool_action(x: float, y: float, z: float, turn: float, *, opened: bool) -> Vector:
    """The action of the kind "pose" for a displacement [m], shortened to the longest one, and a turn [rad]."""
    way = np.array([x, y, z]) / MOVE_M
    longest = float(np.abs(way).max())
    if longest > 1.0:
        way /= longest
    turned = float(np.clip(turn / TURN_RAD, -1.0, 1.0))
    return np.array([*way, turned, 1.0 if opened else -1.0], dtype=np.float32)
