"""Speed and time of a gripper, from statuses with its opening."""

from __future__ import annotations

import numpy as np

from ..poses import Array
from . import estimates
from .estimates import Estimate
from .recordings import RobotRecord

_LEAST_WAY_M = 1e-3
_WATCHED_S = 5.0


def fit_gripper(name: str, record: RobotRecord, key: str, scene_value: float | None) -> list[Estimate]:
    """The speed of a finger and the time from the command to the end of the motion. `key`: of the speed in
    the scene."""
    label = f"robots.{name}.gripper"
    speeds: list[float] = []
    times: list[float] = []
    for i, command in enumerate(record.commands):
        if command.kind != "SetEndEffector" or command.in_program:
            continue
        later = [one.time_s for one in record.commands[i + 1 :] if one.kind == "SetEndEffector"]
        end = min(later[0] if later else np.inf, command.time_s + _WATCHED_S)
        seen = [
            (one.time_s - command.time_s, one.separation_m)
            for one in record.statuses
            if one.separation_m is not None and command.time_s <= one.time_s <= end
        ]
        ramp = _fit_ramp(np.array(seen)) if len(seen) >= 4 else None
        if ramp is not None:
            speeds.append(0.5 * ramp[0])
            times.append(ramp[1])
    if len(speeds) < 2:
        why = f"{len(speeds)} motions of the gripper with its opening in the statuses, at least 2 are needed"
        return [
            estimates.untold(f"{label}.finger_speed_m_s", "m/s", why, key, scene_value),
            estimates.untold(f"{label}.motion_time_s", "s", why),
        ]
    speed = estimates.mean(speeds, f"{label}.finger_speed_m_s", "m/s", key=key, scene_value=scene_value)
    return [speed.judged((0, 2)), estimates.mean(times, f"{label}.motion_time_s", "s").judged((0, _WATCHED_S))]


def _fit_ramp(seen: Array) -> tuple[float, float] | None:
    """Rate of the opening and time of its end; None where fewer than two samples lie on the way."""
    time, opening = seen[:, 0], seen[:, 1]
    first, last = opening[0], opening[-1]
    way = last - first
    if abs(way) < _LEAST_WAY_M:
        return None
    done = (opening - first) / way
    inside = (done > 0.03) & (done < 0.97)
    if inside.sum() < 2:
        return None
    slope, offset = np.polyfit(time[inside], done[inside], 1)
    if slope <= 0:
        return None
    return float(abs(way) * slope), float((1 - offset) / slope)
