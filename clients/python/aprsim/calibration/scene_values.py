"""The values that a scene has today, for what recordings can tell."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ..errors import AprsimError, BadArgument
from ..poses import Array, matrix
from ..world import World
from .line_fit import KnownObject

_VISION = {"position_noise_m": 1e-4, "rotation_noise_deg": 0.1, "drop_rate": 0.0, "rate_hz": 10.0, "latency_s": 0.1}
_GRIPPER = {"palm_stiffness_n_m": 5e3, "palm_damping_ns_m": 200.0}
_AREA_M = 1.2  # of a camera without an area, to each side


@dataclass(frozen=True)
class SceneValues:
    """A scene: its text as a tree, and its objects at the start."""

    name: str
    """As it was given: a name or a file."""
    tree: dict[str, Any]
    X_WR: dict[str, Array]
    """Reference frame of each robot's CRCL poses."""
    X_RV: dict[str, Array]
    """Frame of each robot's camera."""
    bodies: list[tuple[str, Array]]
    """Type and pose in the world of each tray, gear and part."""
    joint_speeds: dict[str, list[float]]
    """Highest speed of each robot's joints [rad/s]."""

    @staticmethod
    def of(scene: str) -> SceneValues:
        """Reads a scene. Raises AprsimError with the cause where it cannot be used."""
        with World(scene) as world:
            tree = yaml.safe_load(world.scene_text())
            if not isinstance(tree, dict):
                raise AprsimError(f"{scene}: a map is expected")
            X_WR, X_RV, speeds = {}, {}, {}
            for robot in world.description.robots:
                X_WR[robot.name] = matrix(robot.base_in_world) @ matrix(robot.reference_in_base)
                X_RV[robot.name] = matrix(robot.vision_in_reference)
                speeds[robot.name] = [joint.max_speed_rad_s for joint in robot.joints]
            snapshot = world.snapshot()
            bodies = [(body.type, body.pose) for body in snapshot.bodies.values()]
        return SceneValues(scene, tree, X_WR, X_RV, bodies, speeds)

    def robots(self) -> list[str]:
        """Names in the scene's order."""
        return list(self.X_WR)

    def robot_name(self, name: str | None) -> str:
        """The robot of this name, by default the first. Raises BadArgument."""
        names = self.robots()
        if name is None:
            if not names:
                raise BadArgument(f"scene: {self.name} has no robot")
            return names[0]
        if name not in names:
            raise BadArgument(f"robot: no robot '{name}', expected one of {', '.join(names)}")
        return name

    def base(self) -> str:
        """The scene as the `base` of another one: a shipped scene's name, or an absolute path."""
        is_file = "/" in self.name or self.name.endswith((".yaml", ".yml"))
        return str(Path(self.name).resolve()) if is_file else self.name

    def robot(self, name: str) -> dict[str, Any]:
        """The entry of a robot in the tree."""
        for one in self.tree.get("robots") or []:
            if one.get("name") == name:
                return dict(one)
        return {}

    def gripper_place(self, name: str) -> tuple[str, str]:
        """The list or map, and the name in it, of the thing whose `gripper` the robot starts with."""
        tool = self.robot(name).get("tool")
        if isinstance(tool, str) and tool != "none":
            return "tools", tool
        return "robot_types", str(self.robot(name).get("type"))

    def _gripper_tree(self, name: str) -> dict[str, Any]:
        where, which = self.gripper_place(name)
        if where == "tools":
            for one in self.tree.get("tools") or []:
                if one.get("name") == which:
                    return dict(one.get("gripper") or {})
            return {}
        return dict((self.tree.get("robot_types", {}).get(which) or {}).get("gripper") or {})

    def limits(self, name: str) -> dict[str, float]:
        """trans_speed_m_s and trans_accel_m_s2."""
        kind = self.tree.get("robot_types", {}).get(self.robot(name).get("type")) or {}
        return _numbers(kind.get("limits") or {})

    def simple_message(self, name: str) -> dict[str, float]:
        """Numbers of the robot's Simple Message server."""
        return _numbers((self.robot(name).get("servers") or {}).get("simple_message") or {})

    def gripper(self, name: str) -> dict[str, float]:
        """Numbers of the gripper."""
        return _GRIPPER | _numbers(self._gripper_tree(name))

    def force(self, name: str) -> dict[str, float]:
        """Errors of the force sensor, and what a press depends on."""
        robot = self.robot(name)
        sensor = robot.get("force_sensor") or {}
        out = {"noise_n": float(sensor.get("noise_n", 0)), "guard_delay_s": float(robot.get("guard_delay_s", 0))}
        for key in ("bias_n", "drift_n_s"):
            for axis, value in enumerate(sensor.get(key) or [0, 0, 0]):
                out[f"{key}[{axis}]"] = float(value)
        relaxation = self._gripper_tree(name).get("palm_relaxation") or {}
        out["palm_relaxation.share"] = float(relaxation.get("share", 0))
        if "time_s" in relaxation:
            out["palm_relaxation.time_s"] = float(relaxation["time_s"])
        gripper = self.gripper(name)
        return out | {key: gripper[key] for key in _GRIPPER}

    def friction(self, name: str) -> float | None:
        """A coefficient of friction of `physics.friction`."""
        return _numbers((self.tree.get("physics") or {}).get("friction") or {}).get(name)

    def conveyor(self) -> dict[str, float]:
        """Numbers of the belt."""
        out = _numbers(self.tree.get("conveyor") or {})
        if "max_accel_m_s2" in out:
            out.setdefault("max_decel_m_s2", out["max_accel_m_s2"])
        return out

    def vision(self, name: str) -> dict[str, float]:
        """Numbers of the robot's camera."""
        return _VISION | _numbers(self.robot(name).get("vision") or {})

    def vision_area(self, name: str) -> tuple[Array, Array]:
        """Lower and upper corner of the area that the robot's camera sees, in the vision frame."""
        area = (self.robot(name).get("vision") or {}).get("area") or {}
        low = np.array(area.get("min_m", [-_AREA_M, -_AREA_M]), float)
        return low, np.array(area.get("max_m", [_AREA_M, _AREA_M]), float)

    def known_objects(self, name: str) -> list[KnownObject]:
        """The bodies of the scene in the vision frame of a robot's camera, within its area."""
        X_VW = np.linalg.inv(self.X_WR[name] @ self.X_RV[name])
        low, high = self.vision_area(name)
        out = []
        for kind, X_WB in self.bodies:
            X_VB = X_VW @ X_WB
            if (X_VB[:2, 3] >= low).all() and (X_VB[:2, 3] <= high).all():
                yaw = math.atan2(X_VB[1, 0], X_VB[0, 0])
                out.append(KnownObject(kind, float(X_VB[0, 3]), float(X_VB[1, 3]), yaw))
        return out


def _numbers(tree: dict[str, Any]) -> dict[str, float]:
    return {
        key: float(value)
        for key, value in tree.items()
        if isinstance(value, (int, float)) and not isinstance(value, bool)
    }
