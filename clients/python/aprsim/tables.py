"""Snapshots as pandas tables, where pandas is installed: one row for each thing in each snapshot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Iterable

from .errors import AprsimError
from .poses import quaternion
from .snapshots import Snapshot

if TYPE_CHECKING:
    import pandas


def bodies_table(snapshots: Iterable[Snapshot]) -> pandas.DataFrame:
    """Gears and trays: time_s, step, body, type, position x y z [m], orientation qw qx qy qz in the
    world, speed components vx vy vz [m/s], resting."""
    rows = []
    for snapshot in snapshots:
        for body in snapshot.bodies.values():
            x, y, z = body.position_m
            vx, vy, vz = body.velocity_m_s
            qw, qx, qy, qz = quaternion(body.pose[:3, :3])
            rows.append(
                {
                    "time_s": snapshot.sim_time_s,
                    "step": snapshot.step,
                    "body": body.name,
                    "type": body.type,
                    **{"x": x, "y": y, "z": z, "qw": qw, "qx": qx, "qy": qy, "qz": qz},
                    **{"vx": vx, "vy": vy, "vz": vz},
                    "resting": body.resting,
                }
            )
    return _pandas().DataFrame(rows)


def robots_table(snapshots: Iterable[Snapshot]) -> pandas.DataFrame:
    """Arms: time_s, step, robot, tool position x y z in the world [m], joints j1 .. [rad], gripper
    separation_m, held, moving."""
    rows = []
    for snapshot in snapshots:
        for robot in snapshot.robots.values():
            x, y, z = robot.tool_in_world[:3, 3]
            joints = {f"j{n}": value for n, value in enumerate(robot.joints_rad, 1)}
            rows.append(
                {
                    "time_s": snapshot.sim_time_s,
                    "step": snapshot.step,
                    "robot": robot.name,
                    **{"x": x, "y": y, "z": z},
                    **joints,
                    "separation_m": robot.separation_m,
                    "held": robot.held_body,
                    "moving": robot.moving,
                }
            )
    return _pandas().DataFrame(rows)


def _pandas() -> Any:
    try:
        import pandas as library
    except ImportError as error:
        raise AprsimError("tables need pandas (Debian: python3-pandas)") from error
    return library
